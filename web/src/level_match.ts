import type { Ears } from './voices';

// As the server matches levels (listener.cpp).
const MEMORY_S = 2;
const WINDOW_S = 0.043;
const LARGEST_GAIN = 10; // 20 dB either way
const SILENT = 1e-10;

const energy = (ears: Ears) =>
  ears.reduce((sum, ear) => ear.reduce((part, sample) => part + sample * sample, sum), 0);

/** Makes sound as loud as the recording is at the same time, over two seconds. */
export class LevelMatch {
  matches = false;

  private readonly window: number;
  private filled = 0; // samples of the window
  private recorded = 0;
  private heard = 0;
  private before = 1; // gains at the beginning and at the end of the window
  private after = 1;

  constructor(rate_hz: number) {
    this.window = Math.round(WINDOW_S * rate_hz);
  }

  /** Forgets the levels; the gain stays, so that it does not jump. */
  reset(): void {
    this.recorded = this.heard = 0;
  }

  /** @param recorded  what the recording has at the time of `ears` */
  apply(recorded: Ears, ears: Ears): void {
    const samples = ears[0].length;
    this.recorded += energy(recorded);
    this.heard += energy(ears);
    if (this.before !== 1 || this.after !== 1) {
      for (let i = 0; i < samples; ++i) {
        const share = Math.min(1, (this.filled + i + 1) / this.window);
        const gain = this.before + share * (this.after - this.before);
        for (const ear of ears) ear[i] = Math.max(-1, Math.min(1, ear[i] * gain));
      }
    }
    this.filled += samples;
    if (this.filled >= this.window) this.next();
  }

  private next(): void {
    this.before = this.after;
    if (!this.matches) {
      this.after = 1;
    } else if (this.recorded > SILENT && this.heard > SILENT) {
      const gain = Math.sqrt(this.recorded / this.heard);
      this.after = Math.max(1 / LARGEST_GAIN, Math.min(LARGEST_GAIN, gain));
    }
    const keep = Math.exp(-this.filled / this.window * (WINDOW_S / MEMORY_S));
    this.recorded *= keep;
    this.heard *= keep;
    this.filled = 0;
  }
}
