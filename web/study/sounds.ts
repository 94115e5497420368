const FADE_S = 0.01;

/** Plays the sounds of a page, one at a time; another sound continues at the time of the last one. */
export class Sounds {
  /** Called with its name when a sound begins, and without when playing stops. */
  onplaying: (name?: string) => void = () => {};
  /** Called when a sound has played to its end. */
  onheard: (name: string) => void = () => {};

  private readonly buffers = new Map<string, AudioBuffer>();
  private playing?: { name: string; source: AudioBufferSourceNode; gain: GainNode; began: number; offset: number };

  constructor(private readonly context: AudioContext) {}

  async load(name: string, bytes: ArrayBuffer): Promise<void> {
    this.buffers.set(name, await this.context.decodeAudioData(bytes));
  }

  /** Starts a sound, at the time of the one that is playing, if any; stops it if it is playing itself. */
  async toggle(name: string): Promise<void> {
    await this.context.resume();
    const before = this.playing;
    this.stop();
    if (before?.name === name) return;
    const buffer = this.buffers.get(name);
    if (!buffer) return;
    const offset = before ? (before.offset + this.context.currentTime - before.began) % buffer.duration : 0;
    const source = new AudioBufferSourceNode(this.context, { buffer });
    const gain = new GainNode(this.context, { gain: 0 });
    gain.gain.linearRampToValueAtTime(1, this.context.currentTime + FADE_S);
    source.connect(gain).connect(this.context.destination);
    const playing = { name, source, gain, began: this.context.currentTime, offset };
    source.onended = () => {
      if (this.playing !== playing) return;
      this.playing = undefined;
      this.onheard(name);
      this.onplaying();
    };
    source.start(0, offset);
    this.playing = playing;
    this.onplaying(name);
  }

  stop(): void {
    const playing = this.playing;
    if (!playing) return;
    this.playing = undefined;
    const now = this.context.currentTime;
    playing.gain.gain.setValueAtTime(1, now);
    playing.gain.gain.linearRampToValueAtTime(0, now + FADE_S);
    playing.source.stop(now + FADE_S);
    this.onplaying();
  }
}
