// Plays a clip from where the listener is: at a sample, by a voice, and from one voice to another without a click. It runs
// in an audio worklet or, where browsers have none, on the page's main thread.
import { Box, Engine, Picture, Point } from '../engine/src/engine';
import type { Pose } from './api';
import { LevelMatch } from './level_match';
import { Motion } from './motion';
import { EngineVoice, Ears, RecordingVoice, ServerVoice, Voice, copyPart } from './voices';

const RAMP_S = 0.005; // from silence to sound and back
const FADE_S = 0.02; // from one voice to another
const REPORT_S = 0.01;
const LOAD_S = 0.5; // over which the load is measured
const PATIENCE_S = 1; // how long the old voice may sound before the new one is ready
const CATCH_UP = 4; // times as fast as it sounds: how a voice warms up beside another
const IN_SILENCE_S = 0.05; // what is warmed up at once while nothing sounds

/** What the engine is told of a clip. */
export interface Scene {
  fov_deg: number;
  picture: Picture | null;
  speaker_box: Box | null;
  speaker_m: Point | null;
}

/** What the page tells the playback. */
export type Order =
  | { sound: Ears } // all of the clip
  | { open: string; model?: { module: WebAssembly.Module; bytes: Uint8Array; scene: Scene } } // without one: the recording
  | { close: true } // the voices that were opened
  | { voice: string | null } // a method that was opened; null: the server's parts
  | { pose: Pose; move: number } // numbered, to be reported when it is heard
  | { matches_level: boolean }
  | { playing: boolean }
  | { leap: number } // to a sample
  | { start: number; part: Float32Array }; // from the server

/** What the playback tells the page, every few milliseconds. */
export interface Report {
  at: number; // sample of the clip that comes next
  played: number; // samples in all
  queued: number; // samples of the server's parts that wait
  parts: number; // of the server that have arrived in all
  voice?: string | null; // that sounds; null: the server's; none: nothing sounds yet
  load: number; // share of the time that the engine takes
  move: number; // the last one that is heard
  leaps: number; // that were carried out in all
  ended: boolean; // the clip's end has passed since the last report
  problem?: string;
}

export class Playback {
  private at = 0;
  private played = 0;
  private parts = 0;
  private playing = false;
  private leapTo?: number;
  private leaps = 0; // that were ordered
  private move = 0;
  private clip: Ears = [];
  private readonly server = new ServerVoice();
  private readonly opened = new Map<string, Voice>();
  private wanted: Voice = this.server;
  private current?: Voice; // that sounds
  private previous?: Voice; // that fades out
  private next?: Voice; // that is being prepared
  private faded = 0; // samples
  private waited = 0; // for the next voice, samples
  private gain = 0;
  private readonly motion: Motion;
  private readonly level: LevelMatch;
  private spent_ms = 0;
  private rendered = 0; // samples, in that time
  private untold = 0; // samples since the last report
  private readonly news: Report = {
    at: 0, played: 0, queued: 0, parts: 0, load: 0, move: 0, leaps: 0, ended: false,
  };

  constructor(
    private readonly samples: number, private readonly rate_hz: number, private readonly tell: (report: Report) => void,
  ) {
    this.motion = new Motion(rate_hz);
    this.level = new LevelMatch(rate_hz);
  }

  obey(order: Order): void {
    if ('part' in order) {
      ++this.parts;
      this.server.push(order.start, order.part);
    } else if ('pose' in order) {
      this.move = order.move;
      this.motion.set(order.pose);
      if (!this.isHeard) this.arrive();
    } else if ('voice' in order) this.choose(order.voice);
    else if ('leap' in order) {
      this.leapTo = order.leap;
      ++this.leaps;
      this.server.clear();
      if (this.current === this.server) this.gain = 0; // there is nothing left to fade out
      if (this.previous === this.server) this.previous = undefined;
    } else if ('playing' in order) this.playing = order.playing;
    else if ('matches_level' in order) this.level.matches = order.matches_level;
    else if ('sound' in order) this.clip = order.sound;
    else if ('close' in order) this.close();
    else this.attempt(() => this.open(order));
  }

  /** Fills both ears; silence where there is nothing to hear. */
  fill(left: Float32Array, right: Float32Array): void {
    left.fill(0); // not every browser clears the memory
    right.fill(0);
    this.attempt(() => {
      this.land();
      this.change(left.length);
      let made = 1;
      for (let done = 0; made > 0 && done < left.length; done += made) {
        const count = Math.min(left.length - done, this.samples - this.at);
        made = this.play([left, right].map((ear) => ear.subarray(done, done + count)));
        this.at += made;
        this.played += made;
        if (this.at < this.samples) continue;
        this.at = 0; // once more from the beginning
        this.news.ended = true;
      }
    });
    this.untold += left.length;
    if (this.untold >= REPORT_S * this.rate_hz) this.report();
  }

  private get isHeard(): boolean {
    return this.current !== undefined && this.gain > 0;
  }

  private open({ open: name, model }: Extract<Order, { open: string }>): void {
    if (!model) {
      this.opened.set(name, new RecordingVoice(this.clip));
      return;
    }
    const engine = Engine.fromModule(model.module, model.bytes);
    const { fov_deg, picture, speaker_box, speaker_m } = model.scene;
    const stream = engine.stream({ sampleRate: this.rate_hz, fovDeg: fov_deg });
    engine.close();
    stream.placeSpeaker(speaker_m);
    stream.see(picture, speaker_box);
    this.opened.set(name, new EngineVoice(stream, this.clip, this.rate_hz));
  }

  private close(): void {
    this.opened.clear();
    this.wanted = this.server;
    this.silence();
  }

  private choose(name: string | null): void {
    if (name === null && this.wanted !== this.server && this.current !== this.server) this.server.clear();
    this.wanted = (name === null ? undefined : this.opened.get(name)) ?? this.server;
  }

  private silence(): void {
    this.current = this.previous = this.next = undefined;
    this.gain = 0;
  }

  private arrive(): void {
    this.motion.arrive();
    for (const voice of [this.current, this.next]) voice?.move(this.motion.pose);
  }

  /** Leaps, as soon as nothing is heard. */
  private land(): void {
    if (this.leapTo === undefined || this.isHeard) return;
    this.at = this.leapTo;
    this.leapTo = undefined;
    this.news.leaps = this.leaps;
    this.news.ended = false;
    this.silence();
    this.arrive();
  }

  /** Prepares the wanted voice and lets it follow the present one. */
  private change(block: number): void {
    if (this.previous || this.leapTo !== undefined) return;
    if (this.wanted === this.current) {
      this.next = undefined;
      return;
    }
    if (this.next !== this.wanted) {
      this.next = this.wanted;
      this.next.move(this.motion.pose);
      this.next.start(this.at);
      this.waited = 0;
    }
    const most = this.isHeard ? CATCH_UP * block : IN_SILENCE_S * this.rate_hz;
    if (this.next.prepare(this.at, most)) {
      if (this.isHeard) this.previous = this.current;
      this.current = this.next;
      this.next = undefined;
      this.faded = 0;
      this.level.reset();
      return;
    }
    this.waited += block;
    if (this.waited > PATIENCE_S * this.rate_hz) this.current = undefined;
  }

  /** @returns how many samples there were to play */
  private play(ears: Ears): number {
    const goal = this.playing && this.leapTo === undefined ? 1 : 0;
    if (goal === 0 && this.gain === 0) return 0;
    if (!this.current?.prepare(this.at, IN_SILENCE_S * this.rate_hz)) {
      this.gain = 0; // it waits for the server, or begins anew
      return 0;
    }
    if (this.motion.advance(ears[0].length)) {
      for (const voice of [this.current, this.previous, this.next]) voice?.move(this.motion.pose);
    }
    const began_ms = Date.now();
    const made = this.current.fill(this.at, ears);
    const heard = ears.map((ear) => ear.subarray(0, made));
    if (this.previous) this.fade(heard);
    if (this.current !== this.server) {
      this.measure(Date.now() - began_ms, made);
      const recorded = heard.map(() => new Float32Array(made));
      copyPart(this.clip, this.at, recorded);
      this.level.apply(recorded, heard);
      this.news.move = this.move;
    }
    this.ramp(heard, goal);
    return made;
  }

  /** The previous voice fades into the sound of the present one. */
  private fade(ears: Ears): void {
    const length = FADE_S * this.rate_hz;
    const before = ears.map((ear) => new Float32Array(ear.length));
    if (this.previous!.prepare(this.at, 0)) this.previous!.fill(this.at, before);
    ears.forEach((ear, side) => {
      for (let i = 0; i < ear.length; ++i) {
        const share = Math.min(1, (this.faded + i + 1) / length);
        ear[i] = before[side][i] + share * (ear[i] - before[side][i]);
      }
    });
    this.faded += ears[0].length;
    if (this.faded >= length) this.previous = undefined;
  }

  private ramp(ears: Ears, goal: number): void {
    if (this.gain === goal) return; // which is then 1
    const step = (goal - this.gain > 0 ? 1 : -1) / (RAMP_S * this.rate_hz);
    for (let i = 0; i < ears[0].length; ++i) {
      this.gain = Math.max(0, Math.min(1, this.gain + step));
      for (const ear of ears) ear[i] *= this.gain;
    }
  }

  /** The clock has steps of a millisecond, but on average it is right. */
  private measure(took_ms: number, samples: number): void {
    this.spent_ms += took_ms;
    this.rendered += samples;
    if (this.rendered < LOAD_S * this.rate_hz) return;
    this.news.load = (this.spent_ms / 1000) * (this.rate_hz / this.rendered);
    this.spent_ms = this.rendered = 0;
  }

  private report(): void {
    this.untold = 0;
    const { news } = this;
    const voice = this.isHeard ? this.nameOf(this.current!) : undefined;
    const queued = this.server.queued(this.at);
    const isNew = news.played !== this.played || news.voice !== voice || news.queued !== queued || news.at !== this.at ||
      news.parts !== this.parts || news.problem !== undefined;
    if (!isNew) return;
    Object.assign(news, { at: this.at, played: this.played, parts: this.parts, queued, voice });
    this.tell({ ...news });
    news.ended = false;
    news.problem = undefined;
  }

  private nameOf(voice: Voice): string | null {
    for (const [name, opened] of this.opened) if (opened === voice) return name;
    return null;
  }

  private attempt(work: () => void): void {
    try {
      work();
    } catch (error) {
      this.close();
      this.news.problem = (error as Error).message;
    }
  }
}
