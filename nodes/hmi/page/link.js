// The socket to the page's server: what arrives by its type, what is sent only while it flows.

const SMALL = 2048; // [bytes] waiting in the socket: what comes behind more would arrive late
const AGAIN = 700; // [ms] until a lost connection is tried again
export const STALLED = 500; // [ms] without a message after which the connection counts as stalled

/** A connection that is made again whenever it is lost. Events: open, lost, and each message type. */
export class Link extends EventTarget {
  constructor(path = "socket") {
    super();
    this.path = path;
    this.open = false;
    this.heard = -Infinity; // [ms] when the last message arrived
    this.next = 1;
  }

  connect() {
    const address = new URL(this.path, location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(address);
    this.socket = socket;
    socket.onopen = () => {
      this.open = true;
      this.heard = performance.now();
      this.dispatchEvent(new Event("open"));
    };
    socket.onmessage = (event) => {
      this.heard = performance.now();
      const message = JSON.parse(event.data);
      this.dispatchEvent(new CustomEvent(message.type, { detail: message }));
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.open = false;
      this.dispatchEvent(new Event("lost"));
      setTimeout(() => this.connect(), AGAIN);
    };
  }

  /** Call `take(message)` for each message of a type. */
  on(type, take) {
    this.addEventListener(type, (event) => take(event.detail));
  }

  /** Whether what is sent now arrives now, as far as a page can know. */
  get flows() {
    return (
      this.open &&
      this.socket.bufferedAmount < SMALL &&
      performance.now() - this.heard < STALLED
    );
  }

  /** Send a message if the socket is open. */
  send(message) {
    if (!this.open) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** Send a request that is answered by its id, and return the id; 0 if it could not be sent. */
  ask(message) {
    const id = this.next++;
    return this.send({ ...message, id }) ? id : 0;
  }
}
