// Where the sound of a clip comes from: the recording, a stream of the engine, or parts that the server has rendered.
import type { Stream } from '../engine/src/engine';
import type { Pose } from './api';

/** As long as the server's (live_sound.cpp), so that after a leap both give the same sound. */
const WARM_UP_S = 0.5;
const CHUNK = 512; // samples that are fed at once while warming up

/** Left and right ear, equally long. */
export type Ears = readonly Float32Array[];

/** The sound of the clip by one method, from any sample on. */
export interface Voice {
  /** Begins anew: fill() will go on from this sample. */
  start(at: number): void;
  /** Works on what has to precede sample `at`, on at most so many samples. @returns whether fill() can go on from there */
  prepare(at: number, most: number): boolean;
  /** Fills both ears from sample `at` on, within the clip. @returns how many samples; fewer: the rest is not there yet */
  fill(at: number, ears: Ears): number;
  move(pose: Pose): void;
}

/** Copies a part of the clip; silence before its beginning and after its end. */
export function copyPart(clip: Ears, start: number, into: Ears): void {
  clip.forEach((ear, side) => {
    const target = into[side];
    const first = Math.min(Math.max(0, -start), target.length);
    const end = Math.max(first, Math.min(target.length, ear.length - start));
    target.fill(0, 0, first).fill(0, end);
    if (end > first) target.set(ear.subarray(start + first, start + end), first);
  });
}

/** The recording as it is. */
export class RecordingVoice implements Voice {
  constructor(private readonly clip: Ears) {}
  start(): void {}
  prepare(): boolean {
    return true;
  }
  fill(at: number, ears: Ears): number {
    copyPart(this.clip, at, ears);
    return ears[0].length;
  }
  move(): void {}
}

/** A stream of the engine. The recording is known in advance and fed early, so that no latency remains. */
export class EngineVoice implements Voice {
  private fed = 0; // the clip's next sample for the stream
  private readonly unheard: Ears = [new Float32Array(CHUNK), new Float32Array(CHUNK)];

  constructor(private readonly stream: Stream, private readonly clip: Ears, private readonly rate_hz: number) {}

  start(at: number): void {
    this.stream.reset();
    this.fed = at - Math.round(WARM_UP_S * this.rate_hz);
  }

  prepare(at: number, most: number): boolean {
    const end = at + this.stream.latency;
    if (this.fed > end) this.start(at);
    for (let left = most; this.fed < end && left > 0; left -= CHUNK) {
      const samples = Math.min(CHUNK, left, end - this.fed);
      this.feed(this.unheard.map((ear) => ear.subarray(0, samples)));
    }
    return this.fed === end;
  }

  fill(_at: number, ears: Ears): number {
    this.feed(ears);
    return ears[0].length;
  }

  move({ x, y, z, yaw_deg }: Pose): void {
    this.stream.moveTo({ x, y, z, yawDeg: yaw_deg });
  }

  private feed(ears: Ears): void {
    copyPart(this.clip, this.fed, ears);
    this.stream.process(ears, ears);
    this.fed += ears[0].length;
  }
}

/** Parts that the server has rendered, left and right interleaved, one after the other. */
export class ServerVoice implements Voice {
  private parts: { start: number; samples: number; sound: Float32Array }[] = [];

  push(start: number, sound: Float32Array): void {
    this.parts.push({ start, samples: sound.length / 2, sound });
  }

  clear(): void {
    this.parts = [];
  }

  /** Samples that wait to be played from `at` on. */
  queued(at: number): number {
    const all = this.parts.reduce((sum, { samples }) => sum + samples, 0);
    const first = this.parts[0];
    return first && this.covers(at) ? all - (at - first.start) : all;
  }

  start(): void {}

  prepare(at: number): boolean {
    while (this.parts.length > 0 && this.parts[0].start < at && !this.covers(at)) this.parts.shift(); // they are late
    return this.covers(at);
  }

  fill(at: number, ears: Ears): number {
    const [left, right] = ears;
    let done = 0;
    while (done < left.length && this.covers(at + done)) {
      const { start, samples, sound } = this.parts[0];
      const first = at + done - start;
      const count = Math.min(left.length - done, samples - first);
      for (let i = 0; i < count; ++i) {
        left[done + i] = sound[2 * (first + i)];
        right[done + i] = sound[2 * (first + i) + 1];
      }
      done += count;
      if (first + count === samples) this.parts.shift();
    }
    return done;
  }

  move(): void {} // poses travel with the requests

  private covers(at: number): boolean {
    const first = this.parts[0];
    return first !== undefined && first.start <= at && at < first.start + first.samples;
  }
}
