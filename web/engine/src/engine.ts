// The live streams of Earpoint in a page, a worker, an audio worklet or Node: a typed face on engine.wasm.

/** A head in the source's frame: metres, x front, y left, z up; degrees, a positive yaw turns left. */
export interface Pose {
  x: number;
  y: number;
  z: number;
  yawDeg?: number;
  /** Positive looks up. */
  pitchDeg?: number;
  /** Positive lowers the right ear. */
  rollDeg?: number;
}

/** A point in the source's frame, metres: [x, y, z]. */
export type Point = readonly [number, number, number];

/** A rectangle in a picture, from 0 to 1 or in pixels; x grows to the right, y downwards. */
export type Box = readonly [xMin: number, yMin: number, xMax: number, yMax: number];

/** RGBA pixels, as a canvas gives them (ImageData), or RGB: [height][width][channels], top row first. */
export interface Picture {
  width: number;
  height: number;
  data: Uint8ClampedArray | Uint8Array;
}

export interface StreamOptions {
  /** Hz, from 16000 to 192000, a multiple of 50. */
  sampleRate: number;
  /** Horizontal field of view of the source's camera, degrees from 10 to 170. Default 90. */
  fovDeg?: number;
  /** Rounds that make the phases of frames consistent, each 20 ms of latency. Default: the network's own. */
  phaseRounds?: number;
  /** For networks trained for both textures: 1 natural, 0 the mean. Default: the network's own. */
  texture?: number;
  /** Sound above 8 kHz follows the gain of the network's top octave. Default true. */
  extendBand?: boolean;
  /** Keep the output within full scale. Default true. */
  limit?: boolean;
}

/** What a caller gave does not fit; the message says where, what is wrong and what to do. */
export class InputError extends Error {}

/** The WebAssembly file: compiled, its bytes, or where it is (fetched). */
export type WasmSource = WebAssembly.Module | ArrayBuffer | Uint8Array | string | URL;
/** A weight file of a gtf network, or a head file for signal processing: its bytes, or where it is (fetched). */
export type WeightSource = ArrayBuffer | Uint8Array | string | URL;

interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  malloc(bytes: number): number;
  free(address: number): void;
  earpoint_error(): number;
  earpoint_status(): number;
  earpoint_model_open(bytes: number, size: number): number;
  earpoint_model_close(model: number): void;
  earpoint_stream_open(
    model: number, rate: number, fovRad: number, rounds: number, texture: number, extend: number, limit: number,
  ): number;
  earpoint_stream_close(stream: number): void;
  earpoint_stream_see(stream: number, rgb: number, width: number, height: number, box: number): number;
  earpoint_stream_place_speaker(stream: number, mouth: number): number;
  earpoint_stream_move_to(
    stream: number, x: number, y: number, z: number, yaw: number, pitch: number, roll: number,
  ): number;
  earpoint_stream_process(stream: number, ears: number, stride: number, frames: number): number;
  earpoint_stream_latency(stream: number): number;
  earpoint_stream_speaker(stream: number, mouth: number): number;
  earpoint_stream_reset(stream: number): void;
}

const BAD_INPUT = 1; // Status::kBadInput of engine.cpp
const DEFAULT_FOV_DEG = 90;
const radians = (degrees: number) => (degrees * Math.PI) / 180;

async function fetched(address: string | URL): Promise<ArrayBuffer> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: the server answered ${response.status}`);
  return response.arrayBuffer();
}

const isAddress = (source: unknown): source is string | URL =>
  typeof source === 'string' || (typeof URL !== 'undefined' && source instanceof URL);

/** Compiles engine.wasm once; the module can be sent to workers and worklets. */
export async function compile(wasm: WasmSource): Promise<WebAssembly.Module> {
  if (wasm instanceof WebAssembly.Module) return wasm;
  return WebAssembly.compile((isAddress(wasm) ? await fetched(wasm) : wasm) as BufferSource);
}

/** The bytes of a weight file. */
export async function readWeights(weights: WeightSource): Promise<Uint8Array> {
  if (isAddress(weights)) return new Uint8Array(await fetched(weights));
  return weights instanceof Uint8Array ? weights : new Uint8Array(weights);
}

/** An instance of engine.wasm with a memory of its own. */
class Instance {
  readonly exports: Exports;
  private view = new Float32Array(0);

  constructor(module: WebAssembly.Module) {
    // The C library's ways to files and to the environment: there are none here. 52 is ENOSYS.
    const refuse = () => 52;
    const system = {
      fd_close: refuse, fd_seek: refuse, fd_write: refuse, fd_read: refuse,
      environ_get: () => 0,
      environ_sizes_get: (count: number, size: number) => {
        const words = new Uint32Array(this.exports.memory.buffer);
        words[count >> 2] = words[size >> 2] = 0;
        return 0;
      },
      proc_exit: (code: number) => {
        throw new Error(`earpoint ended with ${code}`);
      },
    };
    const env = { emscripten_notify_memory_growth: () => {} };
    this.exports = new WebAssembly.Instance(module, { wasi_snapshot_preview1: system, env })
      .exports as unknown as Exports;
    this.exports._initialize();
  }

  /** All of the memory; not to be kept, as it may grow. */
  floats(): Float32Array {
    const { buffer } = this.exports.memory;
    if (this.view.buffer !== buffer) this.view = new Float32Array(buffer);
    return this.view;
  }

  /** Runs `work` with a copy of the bytes in the instance's memory. */
  withBytes<Result>(bytes: Uint8Array | null, work: (address: number) => Result): Result {
    if (bytes === null) return work(0);
    const address = this.exports.malloc(Math.max(1, bytes.length));
    if (address === 0) throw new Error('no memory left');
    try {
      new Uint8Array(this.exports.memory.buffer).set(bytes, address);
      return work(address);
    } finally {
      this.exports.free(address);
    }
  }

  withNumbers<Result>(numbers: readonly number[] | null, work: (address: number) => Result): Result {
    return this.withBytes(numbers && new Uint8Array(Float64Array.from(numbers).buffer), work);
  }

  check(status: number): void {
    if (status !== 0) throw this.problem(status);
  }

  opened(handle: number): number {
    if (handle === 0) throw this.problem(this.exports.earpoint_status());
    return handle;
  }

  private problem(status: number): Error {
    const bytes = new Uint8Array(this.exports.memory.buffer);
    const start = this.exports.earpoint_error();
    let text = '';
    for (let at = start; bytes[at] !== 0; ++at) text += String.fromCharCode(bytes[at]); // worklets have no TextDecoder
    return status === BAD_INPUT ? new InputError(text) : new Error(text);
  }
}

/** A gtf network, or a head for signal processing without a network (dsp), ready for streams. */
export class Engine {
  private constructor(private readonly instance: Instance, private model: number) {}

  /** Loads the WebAssembly file and weights. @throws InputError if these are neither of a gtf network nor a head file */
  static async load(wasm: WasmSource, weights: WeightSource): Promise<Engine> {
    const [module, bytes] = await Promise.all([compile(wasm), readWeights(weights)]);
    return Engine.fromModule(module, bytes);
  }

  /** The same at once, where nothing can be waited for: in a worklet's constructor. */
  static fromModule(module: WebAssembly.Module, weights: Uint8Array): Engine {
    const instance = new Instance(module);
    const model = instance.withBytes(weights, (address) =>
      instance.opened(instance.exports.earpoint_model_open(address, weights.length)));
    return new Engine(instance, model);
  }

  /** A new stream; it lives on when the engine is closed. @throws InputError if an option does not fit */
  stream(options: StreamOptions): Stream {
    return new Stream(this.instance, this.model, options);
  }

  /** Gives the model's memory back. */
  close(): void {
    this.instance.exports.earpoint_model_close(this.model);
    this.model = 0;
  }
}

/**
 * Live sound at an earpoint, block by block. process() takes no longer for large moves; see() encodes the picture,
 * which takes longer than a block of sound.
 */
export class Stream {
  /** Of the output, samples at the stream's rate, for any block size. */
  readonly latency: number;

  private readonly stream: number;
  private ears = 0; // address of [2][room] floats
  private room = 0;

  /** @internal use Engine.stream() */
  constructor(private readonly instance: Instance, model: number, options: StreamOptions) {
    const { sampleRate, fovDeg = DEFAULT_FOV_DEG, phaseRounds = -1, texture = -1, extendBand, limit } = options;
    const flag = (wanted?: boolean) => (wanted === false ? 0 : 1);
    this.stream = instance.opened(instance.exports.earpoint_stream_open(
      model, sampleRate, radians(fovDeg), phaseRounds, texture, flag(extendBand), flag(limit)));
    this.latency = instance.exports.earpoint_stream_latency(this.stream);
  }

  /**
   * The source camera's picture from here on, and where the speaker is seen in it.
   * @throws InputError if the box is no box within the picture
   */
  see(picture: Picture | null, speakerBox: Box | null = null): void {
    const { exports } = this.instance;
    const rgb = picture && rgbOf(picture);
    this.instance.check(this.instance.withBytes(rgb, (pixels) => this.instance.withNumbers(speakerBox, (box) =>
      exports.earpoint_stream_see(this.stream, pixels, picture?.width ?? 0, picture?.height ?? 0, box))));
  }

  /** Position of the speaker's mouth; null: located by picture and sound. @throws InputError beyond 10 km */
  placeSpeaker(mouth: Point | null): void {
    this.instance.check(this.instance.withNumbers(mouth, (address) =>
      this.instance.exports.earpoint_stream_place_speaker(this.stream, address)));
  }

  /** The earpoint from here on. @throws InputError if it is not finite or farther than 10 km */
  moveTo({ x, y, z, yawDeg = 0, pitchDeg = 0, rollDeg = 0 }: Pose): void {
    this.instance.check(this.instance.exports.earpoint_stream_move_to(
      this.stream, x, y, z, radians(yawDeg), radians(pitchDeg), radians(rollDeg)));
  }

  /**
   * Renders the next samples: left and right ear of the source in, of the earpoint out, `latency` samples late. All
   * four are equally long, any length; the output may be the input.
   */
  process(input: readonly Float32Array[], output: readonly Float32Array[]): void {
    const [left, right] = input;
    const frames = left.length;
    const fits = input.length === 2 && output.length === 2 && right.length === frames &&
      output[0].length === frames && output[1].length === frames;
    if (!fits) {
      throw new RangeError('expected two ears in and two out, equally long');
    }
    if (frames > this.room) this.makeRoom(frames);
    const first = this.ears / 4;
    const second = first + this.room;
    const before = this.instance.floats();
    before.set(left, first);
    before.set(right, second);
    this.instance.check(
      this.instance.exports.earpoint_stream_process(this.stream, this.ears, this.room, frames));
    const after = this.instance.floats();
    output[0].set(after.subarray(first, first + frames));
    output[1].set(after.subarray(second, second + frames));
  }

  /** Where the network takes the speaker's mouth to be; null before it has heard something. */
  get speaker(): Point | null {
    return this.instance.withNumbers([0, 0, 0], (address) => {
      if (!this.instance.exports.earpoint_stream_speaker(this.stream, address)) return null;
      const [x, y, z] = new Float64Array(this.instance.exports.memory.buffer, address, 3);
      return [x, y, z] as const;
    });
  }

  /** Back to silence; picture, speaker and earpoint stay. */
  reset(): void {
    this.instance.exports.earpoint_stream_reset(this.stream);
  }

  /** Gives the stream's memory back; it must not be used any more. */
  close(): void {
    this.instance.exports.earpoint_stream_close(this.stream);
    this.instance.exports.free(this.ears);
  }

  private makeRoom(frames: number): void {
    this.instance.exports.free(this.ears);
    this.room = 0; // until there is memory: nothing may be written to address 0
    this.ears = this.instance.exports.malloc(2 * 4 * frames);
    if (this.ears === 0) throw new Error('no memory left');
    this.room = frames;
  }
}

function rgbOf({ width, height, data }: Picture): Uint8Array {
  const pixels = width * height;
  if (pixels === 0 || (data.length !== 4 * pixels && data.length !== 3 * pixels)) {
    throw new InputError(`picture: ${data.length} bytes are not ${width} x ${height} pixels of RGB or RGBA`);
  }
  if (data.length === 3 * pixels) return new Uint8Array(data);
  const rgb = new Uint8Array(3 * pixels);
  for (let i = 0; i < pixels; ++i) {
    for (let c = 0; c < 3; ++c) rgb[3 * i + c] = data[4 * i + c];
  }
  return rgb;
}
