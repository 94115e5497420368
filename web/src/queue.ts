/** Sound that waits to be played, left and right interleaved. */
export class SampleQueue {
  /** Samples per ear that were played so far. */
  played = 0;

  private parts: Float32Array[] = [];
  private at = 0; // numbers of the first part that were played

  push(part: Float32Array): void {
    this.parts.push(part);
  }

  clear(): void {
    this.parts = [];
    this.at = 0;
  }

  /** Fills both ears: silence where there is no sound yet. */
  fill(left: Float32Array, right: Float32Array): void {
    left.fill(0); // not every browser clears the memory
    right.fill(0);
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
  }
}
