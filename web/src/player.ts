import { Clip, Pose, fetchSound, joinAsListener } from './api';

const PART = 2048; // samples asked for at once
const AHEAD_S = 0.09; // sound kept ready, so that a move is heard soon

/** Row of a walk: where one was when a part of the clip was asked for. */
export interface Step extends Pose {
  time_s: number;
}

/** Plays the clip as it is heard from where the listener is. */
export class Player {
  readonly context: AudioContext;
  readonly output: AudioWorkletNode;
  pose: () => Pose = () => ({ x: 0, y: 0, z: 0, yaw_deg: 0 });
  method = 'gtf';
  playing = false;
  walk: Step[] = [];
  /** Share of real time that the server takes for a part. */
  load = 0;

  private next = 0; // sample to be asked for
  private sent = 0; // samples given to the output
  private played = 0;
  private asking = false;

  private constructor(readonly clip: Clip, private readonly listener: string, context: AudioContext) {
    this.context = context;
    this.output = new AudioWorkletNode(context, 'queue', { numberOfInputs: 0, outputChannelCount: [2] });
    this.output.connect(context.destination);
    this.output.port.onmessage = (event) => {
      this.played = event.data as number;
      void this.pump();
    };
  }

  static async open(clip: Clip): Promise<Player> {
    const context = new AudioContext({ sampleRate: clip.sample_rate_hz, latencyHint: 'interactive' });
    await context.audioWorklet.addModule('worklet.js');
    return new Player(clip, await joinAsListener(), context);
  }

  get time_s(): number {
    const waiting = this.sent - this.played;
    return Math.max(0, this.next - waiting) / this.clip.sample_rate_hz;
  }

  /** From a move to its sound: what is ready, and what the system adds. */
  get latency_s(): number {
    const system = (this.context.baseLatency ?? 0) + (this.context.outputLatency ?? 0);
    return AHEAD_S + PART / this.clip.sample_rate_hz + system;
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
    this.walk = [];
    this.output.port.postMessage('clear');
    void this.pump();
  }

  onproblem: (what: string) => void = () => {};

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

  private async ask(): Promise<void> {
    const start = this.next;
    const samples = Math.min(PART, this.clip.samples - start);
    const pose = this.pose();
    const began = performance.now();
    const sound = await fetchSound(this.listener, start, samples, pose, this.method);
    const took_s = (performance.now() - began) / 1000;
    this.load += 0.1 * (took_s / (samples / this.clip.sample_rate_hz) - this.load);
    if (this.next !== start) return; // somebody leapt meanwhile
    this.walk.push({ time_s: start / this.clip.sample_rate_hz, ...pose });
    this.output.port.postMessage(sound, [sound.buffer]);
    this.sent += samples;
    this.next = start + samples;
    if (this.next >= this.clip.samples) {
      this.next = 0; // once more from the beginning
      this.walk = [];
    }
  }
}

/** The walk as `earpoint render --path` reads it. */
export function walkCsv(walk: Step[]): string {
  const rows = walk.map((s) => [s.time_s, s.x, s.y, s.z, s.yaw_deg, 0, 0].map((n) => n.toFixed(4)).join(','));
  return ['time_s,x,y,z,yaw_deg,pitch_deg,roll_deg', ...rows, ''].join('\n');
}
