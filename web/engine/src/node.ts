// The stream as an AudioNode: the engine runs in the page's audio worklet.
import { Box, InputError, Picture, Point, Pose, StreamOptions, WasmSource, WeightSource, compile, readWeights } from './engine';
import type { ProcessorOptions, Report, Request } from './processor';

export interface NodeOptions extends Omit<StreamOptions, 'sampleRate'> {
  wasm: WasmSource;
  weights: WeightSource;
  /** Where processor.js is; by default beside this file. */
  processor?: string | URL;
  picture?: Picture | null;
  speakerBox?: Box | null;
  speaker?: Point | null;
}

/**
 * Two ears in, two ears out, at the context's rate. The earpoint's position is in AudioParams, so that it can be
 * automated: x, y, z in metres, yaw, pitch, roll in degrees.
 */
export class EarpointNode {
  /** The message of an error in the worklet. One while rendering ends the sound; a refused picture or position does not. */
  onproblem: (what: string) => void = () => {};
  /** Where the network takes the speaker's mouth to be. */
  speaker: Point | null = null;

  private constructor(readonly node: AudioWorkletNode, readonly latency: number) {
    node.port.onmessage = ({ data }: MessageEvent<Report>) => {
      if ('problem' in data) this.onproblem(data.problem);
      else if ('speaker' in data) this.speaker = data.speaker;
    };
  }

  /** @throws InputError if the weights or an option do not fit */
  static async create(context: BaseAudioContext, options: NodeOptions): Promise<EarpointNode> {
    const { wasm, weights, processor, picture, speakerBox, speaker, ...stream } = options;
    const [module, bytes] = await Promise.all([
      compile(wasm), readWeights(weights),
      context.audioWorklet.addModule(processor ?? new URL('./processor.js', import.meta.url)),
    ]);
    const processorOptions: ProcessorOptions = { module, weights: bytes, stream, picture, speakerBox, speaker };
    const node = new AudioWorkletNode(context, 'earpoint', {
      numberOfInputs: 1, numberOfOutputs: 1, outputChannelCount: [2], channelCount: 2, channelCountMode: 'explicit',
      processorOptions,
    });
    return new EarpointNode(node, await firstLatency(node));
  }

  /** One of 'x', 'y', 'z' (metres), 'yaw', 'pitch', 'roll' (degrees). */
  parameter(name: 'x' | 'y' | 'z' | 'yaw' | 'pitch' | 'roll'): AudioParam {
    return this.node.parameters.get(name)!;
  }

  /** The earpoint from now on. */
  moveTo({ x, y, z, yawDeg = 0, pitchDeg = 0, rollDeg = 0 }: Pose): void {
    const values = { x, y, z, yaw: yawDeg, pitch: pitchDeg, roll: rollDeg };
    for (const [name, value] of Object.entries(values)) {
      this.parameter(name as keyof typeof values).setValueAtTime(value, this.node.context.currentTime);
    }
  }

  /** As Stream.see(). The sound has a gap of the time that the picture's encoder takes, some milliseconds. */
  see(picture: Picture | null, speakerBox: Box | null = null): void {
    this.send({ see: picture, speakerBox });
  }

  placeSpeaker(mouth: Point | null): void {
    this.send({ placeSpeaker: mouth });
  }

  reset(): void {
    this.send({ reset: true });
  }

  private send(request: Request): void {
    this.node.port.postMessage(request);
  }
}

function firstLatency(node: AudioWorkletNode): Promise<number> {
  return new Promise((resolve, reject) => {
    node.onprocessorerror = () => reject(new Error('the audio worklet failed'));
    node.port.onmessage = ({ data }: MessageEvent<Report>) => {
      if ('latency' in data) resolve(data.latency);
      else if ('problem' in data) reject(new InputError(data.problem));
    };
  });
}
