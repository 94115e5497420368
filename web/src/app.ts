import { Clip, fetchClip } from './api';
import { SceneMap } from './map';
import { Player, walkCsv } from './player';
import { Scope } from './scope';

const METHOD_NAMES: Record<string, string> = { input: 'Recording', gtf: 'There (gtf)' };

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

function showClip(clip: Clip): void {
  element('name').textContent = `${clip.name}, ${clip.duration_s.toFixed(1)} s`;
  const picture = element<HTMLImageElement>('picture');
  if (clip.has_picture) picture.src = '/api/picture';
  picture.hidden = !clip.has_picture;
  element('no-picture').hidden = clip.has_picture;
  if (clip.box) {
    const box = element('box');
    const [x0, y0, x1, y1] = clip.box.map((n) => 100 * n);
    Object.assign(box.style, { left: `${x0}%`, top: `${y0}%`, width: `${x1 - x0}%`, height: `${y1 - y0}%` });
    box.hidden = false;
  }
  for (const warning of clip.warnings) {
    const item = document.createElement('li');
    item.textContent = warning;
    element('warnings').append(item);
  }
}

function download(name: string, text: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], { type: 'text/csv' }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

class Page {
  private player?: Player;
  private scope?: Scope;
  private method = 'gtf';
  private readonly map: SceneMap;
  private readonly play = element<HTMLButtonElement>('play');
  private readonly time = element<HTMLInputElement>('time');

  constructor(private readonly clip: Clip) {
    this.map = new SceneMap(element('map'), clip);
    this.map.onmove = () => this.tellPlace();
    Object.assign(window, { earpoint: { map: this.map } }); // for tests and for the curious
    this.tellPlace();
    this.addMethods();
    this.play.disabled = false;
    this.play.onclick = () => void this.toggle();
    this.time.max = String(clip.duration_s);
    this.time.oninput = () => this.player?.leap(Number(this.time.value));
    element('home').onclick = () => {
      this.map.pose.yaw_deg = 0;
      this.map.moveTo(0, 0);
    };
    element('walk').onclick = () => {
      if (this.player?.walk.length) download('walk.csv', walkCsv(this.player.walk));
      else this.tell('Nothing was walked yet: play the clip first.');
    };
    const height = element<HTMLInputElement>('height');
    height.oninput = () => {
      this.map.pose.z = Number(height.value);
      element('height-text').textContent = `${this.map.pose.z.toFixed(2)} m`;
      this.map.changed();
    };
    requestAnimationFrame(() => this.frame());
  }

  private addMethods(): void {
    const group = element('methods');
    for (const method of this.clip.methods) {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = METHOD_NAMES[method] ?? method;
      button.setAttribute('role', 'radio');
      button.dataset.method = method;
      button.onclick = () => this.choose(method);
      group.append(button);
    }
    this.choose('gtf');
  }

  private choose(method: string): void {
    this.method = method;
    if (this.player) this.player.method = method;
    for (const button of element('methods').children) {
      button.setAttribute('aria-checked', String((button as HTMLElement).dataset.method === method));
    }
  }

  private async toggle(): Promise<void> {
    try {
      if (!this.player) {
        this.player = await Player.open(this.clip);
        this.player.method = this.method;
        this.player.pose = () => this.map.pose;
        this.player.onproblem = (what) => this.tell(what);
        this.scope = new Scope(this.player.output, element('waves'), element('spectrogram'));
        Object.assign(window, { earpoint: { map: this.map, player: this.player, scope: this.scope } });
        this.player.leap(Number(this.time.value));
      }
      if (this.player.playing) this.player.pause();
      else await this.player.play();
      this.tell('');
    } catch (error) {
      this.tell((error as Error).message);
    }
  }

  private tell(what: string): void {
    element('problem').textContent = what;
  }

  private tellPlace(): void {
    const { x, y, z, yaw_deg } = this.map.pose;
    const way = (value: number, more: string, less: string) =>
      `${Math.abs(value).toFixed(1)} m ${value < 0 ? less : more}`;
    element('place').textContent =
      `You are ${way(x, 'ahead', 'behind')}, ${way(y, 'left', 'right')}, ${way(z, 'up', 'down')}; ` +
      `turned ${Math.abs(yaw_deg).toFixed(0)} degrees ${yaw_deg < 0 ? 'right' : 'left'}.`;
  }

  private frame(): void {
    const { player } = this;
    this.play.textContent = player?.playing ? 'Pause' : 'Play';
    if (player) {
      if (document.activeElement !== this.time) this.time.value = String(player.time_s);
      element('time-text').textContent = `${player.time_s.toFixed(1)} s`;
      element('speed').textContent =
        `${(100 * player.load).toFixed(0)} % of real time, ${(1000 * player.latency_s).toFixed(0)} ms from move to sound`;
      if (player.playing) this.scope?.draw();
    }
    requestAnimationFrame(() => this.frame());
  }
}

fetchClip().then(
  (clip) => {
    showClip(clip);
    new Page(clip);
  },
  (error: Error) => {
    element('problem').textContent = error.message;
  },
);
