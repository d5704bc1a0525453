// The second set of buttons of manual mode: a pair for each joint of the arm.
import { jointMoves, jointOf } from "./driving.js";
import { word } from "./words.js";

const find = (id) => document.getElementById(id);

export class Arm {
  /** `hold(button)` connects a button that moves a joint while it is held. */
  constructor({ hold }) {
    this.hold = hold;
    document.addEventListener("language", () => this.#name());
  }

  /** Have the buttons of a robot's joints. */
  take(hello) {
    const buttons = jointMoves(hello).map((move) => {
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.move = move;
      this.hold(button);
      return button;
    });
    find("arm-pad").replaceChildren(...buttons);
    this.#name();
  }

  #name() {
    for (const button of find("arm-pad").children) {
      const { move } = button.dataset;
      const key = move.endsWith("+") ? "part.joint.more" : "part.joint.less";
      button.textContent = word(key, { n: jointOf(move) });
    }
  }
}
