"""The studies by name."""

from importlib import import_module
from inspect import signature
from typing import Any

from studies.study import Study, StudyError

STUDIES = {
    "unfold": "studies.unfolding:Unfold",
    "fold": "studies.unfolding:Fold",
    "broken-joints": "studies.broken_joints:BrokenJoints",
    "wild-joint": "studies.wild_joint:WildJoint",
    "no-model": "studies.no_model:NoModel",
    "encoder-faults": "studies.encoder_faults:EncoderFaults",
    "real-processes": "studies.real_processes:RealProcesses",
    "platform-path": "studies.platform_path:PlatformPath",
    "paper-faults": "studies.paper_faults:PaperFaults",
    "fault-map": "studies.fault_map:FaultMap",
    "told-nothing": "studies.fault_comparison:FaultComparison",
    "directions": "studies.directions:Directions",
    "bars": "studies.bars:Bars",
    "held-out": "studies.held_out:HeldOut",
    "poses": "studies.poses:Poses",
    "ablation": "studies.ablation:Ablation",
    "physics": "studies.physics:Physics",
    "obstacles": "studies.obstacles:Obstacles",
    "fetch": "studies.fetch:Fetch",
    "shared-mode": "studies.shared_mode:SharedMode",
    "mobile-live": "studies.mobile_live:MobileLive",
    "buttons": "studies.buttons:Buttons",
    "buttons-live": "studies.buttons_live:ButtonsLive",
}
"""`module:Class` by name, in the order of the paper."""


def study(name: str, **settings: int) -> Study[Any]:
    """Return the study of that name.

    Args:
        name: Its name.
        **settings: Parameters of its class, such as `seed`.

    Raises:
        StudyError: There is none, or it takes no such parameter; the message lists the valid names.
    """
    if name not in STUDIES:
        raise StudyError(f"there is no study {name!r}; valid are {', '.join(STUDIES)}, all")
    module, _, kind = STUDIES[name].partition(":")
    maker = getattr(import_module(module), kind)
    unknown = [f"--{key}" for key in settings if key not in signature(maker).parameters]
    if unknown:
        raise StudyError(f"study {name} takes no {', '.join(unknown)}")
    made: Study[Any] = maker(**settings)
    return made
