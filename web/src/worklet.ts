/** Plays what the page sends, left and right in turns; silence where nothing is there yet. */
declare const registerProcessor: (name: string, processor: unknown) => void;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}

class Queue extends AudioWorkletProcessor {
  private parts: Float32Array[] = [];
  private at = 0; // samples of the first part that were played
  private played = 0;
  private told = 0;

  constructor() {
    super();
    this.port.onmessage = (event: MessageEvent) => {
      if (event.data === 'clear') {
        this.parts = [];
        this.at = 0;
      } else {
        this.parts.push(event.data as Float32Array);
      }
    };
  }

  process(_inputs: Float32Array[][], outputs: Float32Array[][]): boolean {
    const [left, right] = outputs[0];
    for (let i = 0; i < left.length; ++i) {
      const part = this.parts[0];
      if (!part) break;
      left[i] = part[this.at];
      right[i] = part[this.at + 1];
      this.at += 2;
      ++this.played;
      if (this.at >= part.length) {
        this.parts.shift();
        this.at = 0;
      }
    }
    if (this.played !== this.told) {
      this.told = this.played;
      this.port.postMessage(this.played);
    }
    return true;
  }
}

registerProcessor('queue', Queue);
