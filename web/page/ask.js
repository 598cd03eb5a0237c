// Shared by all parts of the page: elements, the worker, downloads. Text from files is never parsed as markup.
const $ = (id) => document.getElementById(id);

/** An element with properties and children; strings become text nodes. */
function make(name, properties = {}, ...children) {
  const one = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key.includes('-')) one.setAttribute(key, value);
    else one[key] = value;
  }
  one.append(...children.filter((child) => child !== null && child !== undefined));
  return one;
}

/** A text with code between backticks, as children of `make`. */
const withCode = (text) => text.split('`').map((part, k) => (k % 2 ? make('code', {}, part) : part));

/** An error with a hint on a line of its own, as the program's. */
class Hinted extends Error {
  constructor(what, hint) {
    super(`${what}\nhint: ${hint}`);
  }
}

/** Shows a message, also to screen readers. */
function say(where, text, isError = false) {
  where.textContent = text;
  where.classList.toggle('error', isError);
}

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
}

// The program is at the end of the page, so that the page is visible before it has arrived.
const arrived = new Promise((resolve) => addEventListener('DOMContentLoaded', resolve));

let compiling;
/** The program, compiled once. */
function compiled() {
  compiling ??= (async () => {
    await arrived;
    const packed = new Blob([bytesOf($('wasm').textContent)]);
    const whole = packed.stream().pipeThrough(new DecompressionStream('gzip'));
    return WebAssembly.compile(await new Response(whole).arrayBuffer());
  })();
  return compiling;
}

let workerAddress;
class Program {
  constructor() {
    this.asked = new Map();
    this.last = 0;
    this.onReport = () => {};
    this.onSend = () => {};
  }

  async begin() {
    const module = await compiled();
    workerAddress ??= URL.createObjectURL(
      new Blob([bytesOf($('worker').textContent)], { type: 'text/javascript' }),
    );
    this.worker = new Worker(workerAddress);
    this.worker.postMessage({ module });
    this.worker.onmessage = ({ data }) => {
      if (data.report) this.onReport(data.report);
      else if (data.send) this.onSend(data.send);
      else this.answered(data);
    };
    this.worker.onerror = (event) => this.end(`the program does not start: ${event.message || 'no worker'}\nhint: load the page again, in a current version of the browser`);
  }

  answered({ id, answer, error, isFatal }) {
    const asked = this.asked.get(id);
    this.asked.delete(id);
    if (error === undefined) asked?.resolve(answer);
    else if (!isFatal) asked?.reject(new Error(error));
    else {
      const why = `the program failed: ${error}\nhint: the recordings on this page are kept; save them before you try again`;
      asked?.reject(new Error(why));
      this.end(why);
    }
  }

  /** Calls a function of the program; resolves to its result as text. */
  async ask(verb, ...values) {
    if (!this.worker) await (this.beginning ??= this.begin());
    const id = ++this.last;
    return new Promise((resolve, reject) => {
      this.asked.set(id, { resolve, reject });
      this.worker.postMessage({ id, verb, values });
    });
  }

  /** The same for a result in JSON. */
  async document(verb, ...values) {
    return JSON.parse(await this.ask(verb, ...values));
  }

  /** Calls a function without a result. */
  tell(verb, ...values) {
    this.worker?.postMessage({ verb, values });
  }

  /** Ends the present computation. The next call starts a new worker. */
  end(why) {
    this.worker?.terminate();
    this.worker = this.beginning = undefined;
    for (const { reject } of this.asked.values()) reject(new Error(why));
    this.asked.clear();
  }
}

// Separate workers, so that a recording continues during a diagnosis.
const program = new Program();
const recorder = new Program();

function download(name, content, type) {
  const address = URL.createObjectURL(new Blob([content], { type }));
  make('a', { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

const downloadButton = (label, name, content, type) =>
  make('button', { type: 'button', onclick: () => download(name(), content(), type) }, label);

/** A number with four significant digits. */
const shown = (value) => String(Number(value.toPrecision(4)));
