import { Clip, Pose, fetchClip, fetchClips, renderWalk } from './api';
import { element, showChoice, showClip, tell } from './clip_view';
import { EngineChoice, chooseEngine } from './engine_files';
import { SceneMap } from './map';
import { Player } from './player';
import { Scope } from './scope';
import { Walk } from './walk';

const METHOD_NAMES: Record<string, string> = { input: 'Recording', truth: 'Truth' };
const PREFERRED = 'gtf';
const FRAME_MS = 30; // between drawings of the sound

function button(text: string, onclick: () => void): HTMLButtonElement {
  const made = document.createElement('button');
  made.type = 'button';
  made.textContent = text;
  made.onclick = onclick;
  return made;
}

function download(name: string, content: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

class Page {
  private player?: Player;
  private scope?: Scope;
  private method: string;
  private walk: Walk;
  private mode: 'walking' | 'recording' | 'replaying' = 'walking';
  private drawn_ms = 0;
  private readonly map: SceneMap;
  private readonly play = element<HTMLButtonElement>('play');
  private readonly time = element<HTMLInputElement>('time');
  private readonly height = element<HTMLInputElement>('height');
  private readonly match = element<HTMLInputElement>('match');

  constructor(private readonly clip: Clip, private readonly engine: EngineChoice) {
    this.walk = new Walk(clip.duration_s);
    this.map = new SceneMap(element('map'), clip);
    Object.assign(window, { earpoint: this }); // for tests and for the curious
    this.map.onmove = () => this.moved();
    this.method = this.addMethods();
    this.addPlaces();
    this.addWalk();
    this.play.disabled = false;
    this.play.onclick = () => void this.toggle();
    this.time.max = String(clip.duration_s);
    this.time.oninput = () => this.player?.leap(Number(this.time.value));
    this.height.oninput = () => this.map.set({ ...this.map.pose, z: Number(this.height.value) });
    addEventListener('keydown', (event) => {
      const isUsed = event.target instanceof Element && event.target.closest('button, input, select, .button');
      if (event.key !== ' ' || isUsed) return;
      event.preventDefault();
      void this.toggle();
    });
    const leaveReplay = () => this.mode === 'replaying' && this.setMode('walking');
    element('map').addEventListener('pointerdown', leaveReplay);
    element('map').addEventListener('keydown', leaveReplay);
    this.moved();
    requestAnimationFrame((now) => this.frame(now));
  }

  /** @returns the chosen method */
  private addMethods(): string {
    const usable = this.clip.methods.filter(({ missing }) => !missing);
    const chosen = (usable.find(({ name }) => name === PREFERRED) ?? usable[usable.length - 1]).name;
    for (const { name, missing } of this.clip.methods) {
      const label = document.createElement('label');
      label.className = 'method';
      label.dataset.method = name;
      if (missing) label.title = `${name}: ${missing}`;
      const radio = document.createElement('input');
      Object.assign(radio, { type: 'radio', name: 'method', value: name, disabled: Boolean(missing) });
      radio.checked = name === chosen;
      radio.onchange = () => (this.method = name);
      label.append(radio, METHOD_NAMES[name] ?? name);
      element('methods').append(label);
    }
    return chosen;
  }

  private addPlaces(): void {
    element('home').onclick = () => this.map.set({ x: 0, y: 0, z: 0, yaw_deg: 0 });
    element('places').append(
      ...this.clip.places.map((place, i) => button(`${i + 1} ${place.name}`, () => this.map.goTo(place))),
    );
  }

  private addWalk(): void {
    element('record').onclick = () => void this.record();
    element('replay').onclick = () => void this.replay();
    const saves = [button('Save CSV', () => this.saveCsv()), button('Save WAV', () => void this.saveSound('wav'))];
    if (this.clip.has_movie) saves.push(button('Save MP4', () => void this.saveSound('mp4')));
    element('saves').append(...saves);
    this.showMode();
  }

  private async open(): Promise<Player> {
    if (this.player) return this.player;
    const player = await Player.open(this.clip, this.engine);
    player.wish = (time_s) => ({
      pose: this.mode === 'replaying' ? this.follow(time_s) : this.map.pose,
      method: this.method,
      matches_level: this.match.checked,
    });
    player.onpart = (time_s, pose) => {
      if (this.mode === 'recording') this.walk.add({ time_s, ...pose });
    };
    player.onend = () => this.setMode('walking');
    player.onproblem = (what) => tell(what);
    this.scope = new Scope(player.output, element('waves'), element('spectrogram'));
    player.leap(Number(this.time.value));
    this.player = player;
    return player;
  }

  private async attempt(action: (player: Player) => Promise<void>): Promise<void> {
    try {
      await action(await this.open());
      tell('');
    } catch (error) {
      tell((error as Error).message);
    }
  }

  private async toggle(): Promise<void> {
    await this.attempt(async (player) => {
      if (player.playing) player.pause();
      else await player.play();
    });
  }

  private async record(): Promise<void> {
    if (this.mode === 'recording') {
      this.setMode('walking');
      return;
    }
    await this.attempt(async (player) => {
      this.walk = new Walk(this.clip.duration_s);
      this.walk.add({ time_s: 0, ...this.map.pose });
      this.setMode('recording');
      player.leap(0);
      await player.play();
    });
  }

  private async replay(): Promise<void> {
    await this.attempt(async (player) => {
      this.setMode('replaying');
      player.leap(0);
      await player.play();
    });
  }

  private setMode(mode: Page['mode']): void {
    this.mode = mode;
    this.showMode();
  }

  private showMode(): void {
    const isRecording = this.mode === 'recording';
    element('record').textContent = isRecording ? 'Stop recording' : 'Record a walk';
    element('record').setAttribute('aria-pressed', String(isRecording));
    const hasWalk = !this.walk.isEmpty && !isRecording;
    for (const save of element('saves').children) (save as HTMLButtonElement).disabled = !hasWalk;
    element<HTMLButtonElement>('replay').disabled = !hasWalk;
  }

  private follow(time_s: number): Pose {
    this.map.set(this.walk.at(time_s));
    return this.map.pose;
  }

  private saveCsv(): void {
    download('walk.csv', new Blob([this.walk.csv()], { type: 'text/csv' }));
  }

  private async saveSound(format: string): Promise<void> {
    tell(`Rendering the walk with ${this.method}`);
    try {
      download(`walk.${format}`, await renderWalk(this.clip.id, this.method, format, this.walk.csv()));
      tell('');
    } catch (error) {
      tell((error as Error).message);
    }
  }

  private moved(): void {
    this.player?.moved(this.map.pose);
    const { x, y, z, yaw_deg } = this.map.pose;
    const way = (value: number, more: string, less: string) =>
      `${Math.abs(value).toFixed(1)} m ${value < 0 ? less : more}`;
    element('place').textContent =
      `You are ${way(x, 'ahead', 'behind')}, ${way(y, 'left', 'right')}, ${way(z, 'up', 'down')}; ` +
      `turned ${Math.abs(yaw_deg).toFixed(0)} degrees ${yaw_deg < 0 ? 'right' : 'left'}.`;
    this.height.value = String(z);
    element('height-text').textContent = `${z.toFixed(2)} m`;
  }

  private frame(now_ms: number): void {
    requestAnimationFrame((next_ms) => this.frame(next_ms));
    if (now_ms - this.drawn_ms < FRAME_MS) return;
    this.drawn_ms = now_ms;
    const { player } = this;
    this.play.textContent = player?.playing ? 'Pause' : 'Play';
    if (!player) return;
    if (document.activeElement !== this.time) this.time.value = String(player.time_s);
    element('time-text').textContent = `${player.time_s.toFixed(1)} s`;
    const heard = player.latency_s;
    const latency = heard === undefined ? '' : `, ${(1000 * heard).toFixed(0)} ms from move to sound`;
    const why = player.whyServer && ` (${player.whyServer})`;
    const where = player.isInBrowser ? 'in this browser' : `by the server${why}`;
    element('speed').textContent = `${(100 * player.load).toFixed(0)} % of real time${latency}, ${where}`;
    if (player.playing) this.scope?.draw();
  }
}

async function start(): Promise<void> {
  const list = await fetchClips();
  const query = new URLSearchParams(location.search);
  const chosen = query.get('clip') ?? list.clips[0]?.id;
  showChoice(list, chosen);
  if (chosen === undefined) {
    element('name').textContent = 'Drop a video or a sound file here, or open one.';
    return;
  }
  const clip = await fetchClip(chosen);
  showClip(clip);
  new Page(clip, chooseEngine(clip, list, query.get('engine')));
}

start().catch((error: Error) => tell(error.message));
