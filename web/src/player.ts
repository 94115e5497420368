import { Clip, Pose, ServerError, Wish, fetchSound, joinAsListener, leave } from './api';
import { Output, openOutput } from './output';

const PART_S = 0.043; // length of a request
const AHEAD_S = 0.09; // sound kept ready, so that a move is heard soon

/** Plays the clip as it sounds at the listener's pose. */
export class Player {
  readonly output: AudioNode;
  /** What to request for the part that ends at this time of the clip. */
  wish: (time_s: number) => Wish = () => ({
    pose: { x: 0, y: 0, z: 0, yaw_deg: 0 }, method: 'input', matches_level: false,
  });
  /** Called when a part was rendered, with the time and the pose at its end. */
  onpart: (time_s: number, pose: Pose) => void = () => {};
  /** Called at the end of the clip, which then starts again. */
  onend: () => void = () => {};
  onproblem: (what: string) => void = () => {};
  playing = false;
  /** Time until the server answers, as a share of the part's duration. */
  load = 0;
  /** Time from the last measured move until its sound began to change. */
  latency_s?: number;

  private next = 0; // first sample of the next request
  private sent = 0; // samples given to the output
  private played = 0;
  private asking = false;
  private moved_ms?: number; // time of a move that no request contains yet
  private mark?: { sample: number; moved_ms: number }; // first sample of the output after a move, and its time

  private constructor(
    readonly clip: Clip, private listener: string, readonly context: AudioContext, private readonly queue: Output,
  ) {
    this.output = queue.node;
    queue.onplayed = (samples) => {
      this.played = samples;
      this.measureLatency();
      void this.pump();
    };
    addEventListener('pagehide', () => leave(this.listener));
  }

  static async open(clip: Clip): Promise<Player> {
    const context = new AudioContext({ sampleRate: clip.sample_rate_hz, latencyHint: 'interactive' });
    const queue = await openOutput(context);
    return new Player(clip, await joinAsListener(clip.id), context, queue);
  }

  get time_s(): number {
    const waiting = this.sent - this.played;
    return Math.max(0, this.next - waiting) / this.clip.sample_rate_hz;
  }

  async play(): Promise<void> {
    await this.context.resume();
    this.playing = true;
    await this.pump();
  }

  pause(): void {
    this.playing = false;
  }

  leap(time_s: number): void {
    this.next = Math.min(Math.round(time_s * this.clip.sample_rate_hz), this.clip.samples - 1);
    this.sent = this.played;
    this.mark = this.moved_ms = undefined;
    this.queue.clear();
    void this.pump();
  }

  /** Notes a move, to measure the time until it is heard. */
  moved(): void {
    if (this.playing && !this.mark) this.moved_ms ??= performance.now();
  }

  private measureLatency(): void {
    if (!this.mark || this.played < this.mark.sample) return;
    const system_s = (this.context.baseLatency ?? 0) + (this.context.outputLatency ?? 0);
    this.latency_s = (performance.now() - this.mark.moved_ms) / 1000 + system_s;
    this.mark = undefined;
  }

  private async pump(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      while (this.playing && this.sent - this.played < AHEAD_S * this.clip.sample_rate_hz) await this.ask();
    } catch (error) {
      this.playing = false;
      this.onproblem((error as Error).message);
    } finally {
      this.asking = false;
    }
  }

  /** Sound from the server, which forgets listeners that made no request for long. */
  private async fetch(start: number, samples: number, wish: Wish): Promise<Float32Array> {
    try {
      return await fetchSound(this.listener, start, samples, wish);
    } catch (error) {
      if (!(error instanceof ServerError && error.status === 404)) throw error;
      this.listener = await joinAsListener(this.clip.id);
      return fetchSound(this.listener, start, samples, wish);
    }
  }

  private async ask(): Promise<void> {
    const rate_hz = this.clip.sample_rate_hz;
    const start = this.next;
    const samples = Math.min(Math.round(PART_S * rate_hz), this.clip.samples - start);
    const end_s = (start + samples) / rate_hz;
    const wish = this.wish(end_s);
    const pose = { ...wish.pose };
    if (this.moved_ms !== undefined) this.mark = { sample: this.sent, moved_ms: this.moved_ms };
    this.moved_ms = undefined;
    const began = performance.now();
    const sound = await this.fetch(start, samples, wish);
    const took_s = (performance.now() - began) / 1000;
    this.load += 0.1 * (took_s / (samples / rate_hz) - this.load);
    if (this.next !== start) return; // the user has jumped meanwhile
    this.queue.push(sound);
    this.sent += samples;
    this.next = start + samples;
    this.onpart(end_s, pose);
    if (this.next >= this.clip.samples) {
      this.next = 0; // once more from the beginning
      this.onend();
    }
  }
}
