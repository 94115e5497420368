// The stream as an AudioWorkletProcessor, 'earpoint'. Its position comes from parameters, everything else by messages.
import { Box, Engine, Picture, Point, Stream, StreamOptions } from './engine';

declare const sampleRate: number;
declare const registerProcessor: (name: string, processor: unknown) => void;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}

/** What the node sends at first, and later. */
export interface ProcessorOptions {
  module: WebAssembly.Module;
  weights: Uint8Array;
  stream: Omit<StreamOptions, 'sampleRate'>;
  picture?: Picture | null;
  speakerBox?: Box | null;
  speaker?: Point | null;
}
export type Request =
  | { see: Picture | null; speakerBox: Box | null }
  | { placeSpeaker: Point | null }
  | { reset: true };
export type Report = { latency: number } | { problem: string } | { speaker: Point | null };

const PARAMETERS = ['x', 'y', 'z', 'yaw', 'pitch', 'roll'] as const;
const REPORT_S = 0.25; // from one report of the speaker's position to the next

class Earpoint extends AudioWorkletProcessor {
  static get parameterDescriptors() {
    return PARAMETERS.map((name) => ({ name, defaultValue: 0, automationRate: 'k-rate' }));
  }

  private stream?: Stream;
  private silence = new Float32Array(0);
  private samplesToReport = 0;

  constructor({ processorOptions }: { processorOptions: ProcessorOptions }) {
    super();
    this.port.onmessage = ({ data }: MessageEvent<Request>) => this.attempt(() => this.answer(data));
    this.attempt(() => this.open(processorOptions));
  }

  process(inputs: Float32Array[][], outputs: Float32Array[][], values: Record<string, Float32Array>): boolean {
    const [output] = outputs;
    if (!this.stream) return false;
    return this.attempt(() => {
      const { x, y, z, yaw, pitch, roll } = values;
      this.stream!.moveTo({
        x: x[0], y: y[0], z: z[0], yawDeg: yaw[0], pitchDeg: pitch[0], rollDeg: roll[0],
      });
      this.stream!.process(this.ears(inputs[0], output[0].length), output);
      this.report(output[0].length);
    });
  }

  private open(options: ProcessorOptions): void {
    const engine = Engine.fromModule(options.module, options.weights);
    const stream = engine.stream({ ...options.stream, sampleRate });
    engine.close();
    stream.placeSpeaker(options.speaker ?? null);
    stream.see(options.picture ?? null, options.speakerBox ?? null);
    this.stream = stream;
    this.tell({ latency: stream.latency });
  }

  /** Two ears; silence while nothing is connected, both the same of one channel. */
  private ears(input: Float32Array[], samples: number): Float32Array[] {
    if (this.silence.length !== samples) this.silence = new Float32Array(samples);
    return [input[0] ?? this.silence, input[1] ?? input[0] ?? this.silence];
  }

  private answer(request: Request): void {
    if ('see' in request) this.stream?.see(request.see, request.speakerBox);
    else if ('placeSpeaker' in request) this.stream?.placeSpeaker(request.placeSpeaker);
    else this.stream?.reset();
  }

  private report(samples: number): void {
    this.samplesToReport -= samples;
    if (this.samplesToReport > 0) return;
    this.samplesToReport = REPORT_S * sampleRate;
    this.tell({ speaker: this.stream!.speaker });
  }

  private tell(report: Report): void {
    this.port.postMessage(report);
  }

  private attempt(work: () => void): boolean {
    try {
      work();
      return true;
    } catch (error) {
      this.tell({ problem: (error as Error).message });
      return false;
    }
  }
}

registerProcessor('earpoint', Earpoint);
