import { Order, Playback } from './playback';

declare const sampleRate: number;
declare const registerProcessor: (name: string, processor: unknown) => void;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}

/** Plays the clip, and reports how far it is. */
class PlaybackProcessor extends AudioWorkletProcessor {
  private readonly playback: Playback;

  constructor({ processorOptions }: { processorOptions: { samples: number } }) {
    super();
    this.playback = new Playback(processorOptions.samples, sampleRate, (report) => this.port.postMessage(report));
    this.port.onmessage = ({ data }: MessageEvent<Order>) => this.playback.obey(data);
  }

  process(_inputs: Float32Array[][], outputs: Float32Array[][]): boolean {
    const [left, right] = outputs[0];
    this.playback.fill(left, right);
    return true;
  }
}

registerProcessor('playback', PlaybackProcessor);
