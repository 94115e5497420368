import { Clip, Pose, ServerError, Wish, fetchSound, joinAsListener, leave } from './api';
import type { EngineChoice, EngineFiles } from './engine_files';
import { Output, openOutput } from './output';
import type { Report } from './playback';

const PART_S = 0.043; // length of a request to the server
const AHEAD_S = 0.09; // the server's sound that is kept ready, so that a move is heard soon
const LEAD_S = 0.06; // from the present place to the first part of the server when it takes over
const LOADING_S = 3; // if the engine's files take longer, the server begins
const TOO_SLOW_S = 3; // after so long above real time the server takes over

const AT_CAMERA: Pose = { x: 0, y: 0, z: 0, yaw_deg: 0 };
const isSame = (a: Pose, b: Pose) => a.x === b.x && a.y === b.y && a.z === b.z && a.yaw_deg === b.yaw_deg;

/** Plays the clip as it sounds at the listener's pose, rendered by the page's engine or by the server. */
export class Player {
  readonly output: AudioNode;
  /** What is to be heard at this time of the clip, or in the server's part that ends then. */
  wish: (time_s: number) => Wish = () => ({ pose: AT_CAMERA, method: 'input', matches_level: false });
  /** Called when sound was rendered, with the time and the pose at its end. */
  onpart: (time_s: number, pose: Pose) => void = () => {};
  /** Called at the end of the clip, which then starts again. */
  onend: () => void = () => {};
  onproblem: (what: string) => void = () => {};
  playing = false;
  /** Share of real time: of the engine, or until the server answers. */
  load = 0;
  /** Time from the last measured move until its sound began to change. */
  latency_s?: number;
  /** What sounds: a method by the page's engine, or null: the server's sound. */
  voice?: string | null;
  /** The method that the present sound is of. */
  method = '';
  /** Samples that were played. */
  played = 0;
  /** Why the server renders; nothing: it need not, except for methods that it alone has. */
  whyServer = '';

  private at = 0; // sample of the clip
  private wanted: string | null = null; // voice
  private pose = AT_CAMERA; // that the output was told last
  private moves = 0;
  private matches = false;
  private readonly browserMethods = new Set<string>();
  private isForced = false;
  private failure = ''; // of the engine, where nobody else may render
  private slow_s = 0;
  private told_s = 0; // time of the last part that was told
  private leaps = 0;
  private moved_ms?: number; // time of a move that nothing was told of yet
  private mark?: { move?: number; sample?: number; moved_ms: number }; // what ends the measurement of a move

  // Of the server.
  private listener?: string;
  private next = 0; // first sample of the next request
  private queued = 0; // samples in the output at its last report
  private unseen: number[] = []; // samples of the parts that it had not seen then
  private seen = 0; // parts
  private asking = false;
  private serverMethod = 'input';

  private constructor(readonly clip: Clip, readonly context: AudioContext, private readonly out: Output) {
    this.output = out.node;
    out.onreport = (report) => this.take(report);
    addEventListener('pagehide', () => this.listener && leave(this.listener));
  }

  static async open(clip: Clip, engine: EngineChoice): Promise<Player> {
    const context = new AudioContext({ sampleRate: clip.sample_rate_hz, latencyHint: 'interactive' });
    const player = new Player(clip, context, await openOutput(context, clip.samples));
    if ('why' in engine) {
      player.whyServer = engine.why;
      return player;
    }
    player.whyServer = 'the engine is being loaded';
    const ready = player.useEngine(engine.files, engine.isForced);
    const patience = new Promise((resolve) => setTimeout(resolve, 1000 * LOADING_S));
    try {
      await (engine.isForced ? ready : Promise.race([ready, patience]));
      return player;
    } catch (error) {
      await context.close(); // it is opened again at the next attempt
      throw error;
    }
  }

  get time_s(): number {
    return this.at / this.clip.sample_rate_hz;
  }

  /** Samples that were played or wait to be. */
  get sent(): number {
    return this.played + this.waiting;
  }

  /** Whether the page's engine renders what sounds, or nothing sounds and it would. */
  get isInBrowser(): boolean {
    return (this.voice === undefined ? this.wanted : this.voice) !== null;
  }

  async play(): Promise<void> {
    if (this.failure) throw new Error(this.failure);
    await this.context.resume();
    this.playing = true;
    this.request(this.time_s);
    this.out.send({ playing: true });
    await this.pump();
  }

  pause(): void {
    this.playing = false;
    this.out.send({ playing: false });
  }

  leap(time_s: number): void {
    this.at = this.next = Math.min(Math.round(time_s * this.clip.sample_rate_hz), this.clip.samples - 1);
    this.mark = this.moved_ms = undefined;
    this.out.send({ leap: this.at });
    ++this.leaps;
    this.queued = 0;
    this.unseen.fill(0);
    if (this.wanted !== null) this.request(this.time_s);
    void this.pump();
  }

  /** Follows a move, and measures the time until it is heard. */
  moved(pose: Pose): void {
    if (this.playing && !this.mark) this.moved_ms ??= performance.now();
    if (this.wanted !== null) this.tellPose(pose);
  }

  private async useEngine(files: Promise<EngineFiles>, isForced: boolean): Promise<void> {
    this.isForced = isForced;
    try {
      const { sound, scene, module, models } = await files;
      this.out.send({ sound }, sound.map((ear) => ear.buffer));
      for (const [name, bytes] of models) {
        this.out.send({ open: name, model: bytes && { module, bytes, scene } });
        this.browserMethods.add(name);
      }
      this.whyServer = '';
    } catch (error) {
      this.giveUp((error as Error).message);
      if (isForced) throw new Error(this.failure);
    }
  }

  /** The server renders from now on, unless the address forbids it. */
  private giveUp(why: string): void {
    this.browserMethods.clear();
    this.out.send({ close: true });
    this.whyServer = why;
    if (this.isForced) {
      this.failure = `the page's engine failed: ${why}`;
      this.pause();
      this.onproblem(this.failure);
      return;
    }
    this.wanted = null;
    this.leap(this.time_s);
  }

  /** Tells the output what is wished. @returns the wish */
  private request(time_s: number): Wish {
    const wish = this.wish(time_s);
    const voice = this.browserMethods.has(wish.method) ? wish.method : null;
    if (voice === null) this.serverMethod = wish.method;
    if (voice !== this.wanted) {
      this.wanted = voice;
      this.out.send({ voice });
      if (voice === null && this.voice !== null) this.next = this.ahead();
    }
    if (wish.matches_level !== this.matches) {
      this.matches = wish.matches_level;
      this.out.send({ matches_level: this.matches });
    }
    this.tellPose(wish.pose);
    return wish;
  }

  /** Where the server takes over. */
  private ahead(): number {
    const lead_s = this.playing && this.voice !== undefined ? LEAD_S : 0;
    return (this.at + Math.round(lead_s * this.clip.sample_rate_hz)) % this.clip.samples;
  }

  private tellPose(pose: Pose): void {
    if (isSame(pose, this.pose)) return;
    this.pose = { ...pose };
    this.out.send({ pose: this.pose, move: ++this.moves });
    if (this.moved_ms === undefined || this.wanted === null) return;
    this.mark = { move: this.moves, moved_ms: this.moved_ms };
    this.moved_ms = undefined;
  }

  private take(report: Report): void {
    if (report.problem !== undefined) return this.giveUp(report.problem);
    const elapsed_s = (report.played - this.played) / this.clip.sample_rate_hz;
    this.played = report.played;
    if (report.leaps !== this.leaps) return; // it is of before the last leap
    this.at = report.at;
    this.voice = report.voice;
    this.queued = report.queued;
    this.unseen.splice(0, report.parts - this.seen);
    this.seen = report.parts;
    this.method = report.voice ?? this.serverMethod;
    this.measureLatency(report.move);
    if (report.voice) {
      this.load = report.load;
      this.watch(report.load, elapsed_s);
      if (report.ended) this.onend();
      if (this.playing) this.tellPart(this.request(this.time_s).pose);
    } else if (this.wanted !== null && this.playing) this.request(this.time_s);
    void this.pump();
  }

  /** As often as the server's parts are told. */
  private tellPart(pose: Pose): void {
    const elapsed_s = this.time_s - this.told_s;
    if (elapsed_s >= 0 && elapsed_s < PART_S) return;
    this.told_s = this.time_s;
    this.onpart(this.time_s, pose);
  }

  private watch(load: number, elapsed_s: number): void {
    this.slow_s = load > 1 ? this.slow_s + elapsed_s : 0;
    if (this.slow_s > TOO_SLOW_S && !this.isForced) this.giveUp('this computer is too slow');
  }

  private measureLatency(move: number): void {
    const { mark } = this;
    if (!mark) return;
    const isHeard = mark.move !== undefined ? move >= mark.move : this.played >= mark.sample!;
    if (!isHeard) return;
    const system_s = (this.context.baseLatency ?? 0) + (this.context.outputLatency ?? 0);
    this.latency_s = (performance.now() - mark.moved_ms) / 1000 + system_s;
    this.mark = undefined;
  }

  /** The server's samples that are not played yet. */
  private get waiting(): number {
    return this.unseen.reduce((sum, samples) => sum + samples, this.queued);
  }

  /** Keeps the server's sound ready: while it is wanted, and until the engine has taken over. */
  private async pump(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      const isUsed = () => this.playing && (this.wanted === null || this.voice === null);
      while (isUsed() && this.waiting < AHEAD_S * this.clip.sample_rate_hz) await this.ask();
    } catch (error) {
      this.pause();
      this.onproblem((error as Error).message);
    } finally {
      this.asking = false;
    }
  }

  /** Sound from the server, which forgets listeners that made no request for long. */
  private async fetch(start: number, samples: number, wish: Wish): Promise<Float32Array> {
    this.listener ??= await joinAsListener(this.clip.id);
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
    // While the engine takes over, the wish is for its method.
    const wish = this.wanted === null ? this.request(end_s) : { pose: this.pose, matches_level: this.matches };
    const pose = { ...wish.pose };
    if (this.moved_ms !== undefined && this.wanted === null) this.mark = { sample: this.sent, moved_ms: this.moved_ms };
    if (this.wanted === null) this.moved_ms = undefined;
    const began = performance.now();
    const sound = await this.fetch(start, samples, { ...wish, pose, method: this.serverMethod });
    const took_s = (performance.now() - began) / 1000;
    if (!this.voice) this.load += 0.1 * (took_s / (samples / rate_hz) - this.load);
    if (this.next !== start) return; // the user has jumped meanwhile
    this.out.send({ start, part: sound }, [sound.buffer]);
    this.unseen.push(samples);
    this.next = start + samples;
    const isServers = this.wanted === null;
    if (isServers) this.onpart(end_s, pose);
    if (this.next < this.clip.samples) return;
    this.next = 0; // once more from the beginning
    if (isServers) this.onend();
  }
}
