// The connection to the server; see pyros1/web/server/wire.py. It reconnects automatically.

const MAX_RETRY_DELAY = 4000;
const HEARTBEAT = 4000; // milliseconds between requests for the server's state
const TIMEOUT = 12000; // milliseconds without data from the server after which the connection counts as lost

export class Robot extends EventTarget {
  constructor(token) {
    super();
    this.token = token;
    this.state = "connecting"; // or "connected", "refused"
    this.trouble = "";
    this.about = { version: "", master: "", read_only: false };
    this.masterProblem = ""; // why the master does not respond
    this._calls = new Map();
    this._streams = new Map();
    this._lastId = 0;
    this._retryDelay = 500;
    this._socket = this._connect();
    // A browser may keep a page in its back/forward cache with its connection open: close it, to release what the page uses.
    addEventListener("pagehide", () => this._socket.close());
  }

  // Call a function of the server; see pyros1/web/calls. The promise rejects with an Error whose message can be displayed.
  call(name, args = {}) {
    return new Promise((resolve, reject) => {
      if (this.state !== "connected") {
        reject(new Error("the server does not answer"));
        return;
      }
      const id = ++this._lastId;
      this._calls.set(id, { resolve, reject });
      this._send({ call: name, id, args });
    });
  }

  // Open a stream of a view; see pyros1/web/views.
  // on: {data(data, blob), problem(text), opened()}; problem is called with "" when a problem has gone, and opened again after each reconnect.
  stream(view, args, on) {
    const id = ++this._lastId;
    const stream = { view, args, on };
    this._streams.set(id, stream);
    if (this.state === "connected") this._open(id, stream);
    return {
      change: (changed) => {
        stream.args = changed;
        if (this.state === "connected") this._send({ change: id, args: changed });
      },
      close: () => {
        if (this._streams.delete(id) && this.state === "connected") this._send({ close: id });
      },
    };
  }

  // Return the socket of a new connection; a lost one is replaced.
  _connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const url = `${scheme}//${location.host}/ws?token=${encodeURIComponent(this.token)}`;
    const socket = new WebSocket(url, "pyros1.v1");
    socket.binaryType = "arraybuffer";
    let opened = false;
    let lastReceived = performance.now();
    // A connection may die silently: the server is suspended, or this computer has changed its network.
    const pulse = setInterval(() => {
      if (performance.now() - lastReceived > TIMEOUT) closed();
      else if (opened) this._requestAbout(false);
    }, HEARTBEAT);
    socket.onopen = () => {
      opened = true;
      this._retryDelay = 500;
      this._setState("connected");
      for (const [id, stream] of this._streams) this._open(id, stream);
      this._requestAbout(true);
    };
    socket.onmessage = (event) => {
      lastReceived = performance.now();
      this._receive(event.data);
    };
    const closed = () => {
      clearInterval(pulse);
      socket.onclose = socket.onmessage = null;
      socket.close();
      for (const { reject } of this._calls.values()) reject(new Error("the connection to the server was lost"));
      this._calls.clear();
      if (opened) this._setState("connecting", "the server does not answer; is pyros1 web running?");
      else this._explainRefusal();
      setTimeout(() => { this._socket = this._connect(); }, this._retryDelay);
      this._retryDelay = Math.min(MAX_RETRY_DELAY, this._retryDelay * 1.5);
    };
    socket.onclose = closed;
    return socket;
  }

  async _requestAbout(isNew) {
    let response;
    try {
      response = await this.call("page.about");
    } catch {
      return; // the next connection will ask again
    }
    const { trouble, ...about } = response;
    this.about = about;
    if (isNew) this.dispatchEvent(new Event("about"));
    if (trouble === this.masterProblem) return;
    this.masterProblem = trouble;
    this.dispatchEvent(new Event("master"));
  }

  // A WebSocket does not report why it was refused; a plain request does.
  async _explainRefusal() {
    try {
      const response = await fetch(`/ws?token=${encodeURIComponent(this.token)}`, { signal: AbortSignal.timeout(TIMEOUT) });
      const text = await response.text();
      if (response.status === 401 || response.status === 403 || response.status === 503) this._setState("refused", text.trim());
    } catch {
      this._setState("connecting", "the server does not answer; is pyros1 web running?");
    }
  }

  _setState(state, trouble = "") {
    this.state = state;
    this.trouble = trouble;
    this.dispatchEvent(new Event("state"));
  }

  _open(id, stream) {
    stream.on.opened?.();
    this._send({ open: stream.view, stream: id, args: stream.args });
  }

  _send(request) {
    if (this._socket.readyState === WebSocket.OPEN) this._socket.send(JSON.stringify(request));
  }

  _receive(frame) {
    let blob = null;
    let text = frame;
    if (typeof frame !== "string") {
      const length = new DataView(frame).getUint32(0, true);
      text = new TextDecoder().decode(new Uint8Array(frame, 4, length));
      blob = { buffer: frame, offset: 4 + length };
    }
    const message = JSON.parse(text);
    if (message.stream !== undefined) this._handlePush(message, blob);
    else this._handleResponse(message);
  }

  _handleResponse(message) {
    const call = this._calls.get(message.id);
    this._calls.delete(message.id);
    if (message.error !== undefined) call?.reject(new Error(message.error));
    else call?.resolve(message.result);
  }

  _handlePush(message, blob) {
    const stream = this._streams.get(message.stream);
    if (!stream) return;
    if (message.error !== undefined) {
      stream.failed = true;
      stream.on.problem?.(message.error);
      return;
    }
    // Request the next push when this one is on the screen; a hidden page requests none.
    const next = () => requestAnimationFrame(() => this._streams.has(message.stream) && this._send({ next: message.stream }));
    let drawn;
    try {
      if (stream.failed) stream.on.problem?.(""); // only after a failure of the stream, since a problem that the panel itself reports must stay
      stream.failed = false;
      drawn = stream.on.data(message.data, blob);
    } finally {
      Promise.resolve(drawn).then(next, next); // decoding an image takes time
    }
  }
}
