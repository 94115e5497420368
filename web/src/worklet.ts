import { SampleQueue } from './queue';

declare const registerProcessor: (name: string, processor: unknown) => void;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}

/** Plays what the page sends, and reports how much was played. */
class Queue extends AudioWorkletProcessor {
  private readonly queue = new SampleQueue();
  private told = 0;

  constructor() {
    super();
    this.port.onmessage = (event: MessageEvent) => {
      if (event.data === 'clear') this.queue.clear();
      else this.queue.push(event.data as Float32Array);
    };
  }

  process(_inputs: Float32Array[][], outputs: Float32Array[][]): boolean {
    const [left, right] = outputs[0];
    this.queue.fill(left, right);
    if (this.queue.played !== this.told) {
      this.told = this.queue.played;
      this.port.postMessage(this.told);
    }
    return true;
  }
}

registerProcessor('queue', Queue);
