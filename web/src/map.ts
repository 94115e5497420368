import { Clip, Pose } from './api';

const REACH_M = 5; // the network was trained on moves up to here

function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** The scene from above: the camera looks up the page, you are dragged. */
export class SceneMap {
  readonly pose: Pose = { x: 0, y: 0, z: 0, yaw_deg: 0 };
  onmove: () => void = () => {};

  constructor(private readonly canvas: HTMLCanvasElement, private readonly clip: Clip) {
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.drag(event);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons) this.drag(event);
    });
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.turn(event.deltaY > 0 ? -5 : 5);
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
  }

  moveTo(x: number, y: number): void {
    this.pose.x = Math.max(-REACH_M, Math.min(REACH_M, x));
    this.pose.y = Math.max(-REACH_M, Math.min(REACH_M, y));
    this.changed();
  }

  turn(by_deg: number): void {
    this.pose.yaw_deg = ((this.pose.yaw_deg + by_deg + 540) % 360) - 180;
    this.changed();
  }

  changed(): void {
    this.draw();
    this.onmove();
  }

  private get scale(): number {
    return Math.min(this.canvas.clientWidth, this.canvas.clientHeight) / (2 * REACH_M + 1);
  }

  /** x front is up, y left is left. */
  private toPage(x: number, y: number): [number, number] {
    return [this.canvas.clientWidth / 2 - y * this.scale, this.canvas.clientHeight / 2 - x * this.scale];
  }

  /** Where a place is drawn, in the page's pixels; by default where you are. */
  pagePoint(x = this.pose.x, y = this.pose.y): [number, number] {
    const bounds = this.canvas.getBoundingClientRect();
    const [across, down] = this.toPage(x, y);
    return [bounds.left + across, bounds.top + down];
  }

  private drag(event: PointerEvent): void {
    const bounds = this.canvas.getBoundingClientRect();
    const across = event.clientX - bounds.left - bounds.width / 2;
    const down = event.clientY - bounds.top - bounds.height / 2;
    this.moveTo(-down / this.scale, -across / this.scale);
  }

  private key(event: KeyboardEvent): void {
    const step = 0.1;
    const { x, y } = this.pose;
    const keys: Record<string, () => void> = {
      ArrowUp: () => this.moveTo(x + step, y),
      ArrowDown: () => this.moveTo(x - step, y),
      ArrowLeft: () => this.moveTo(x, y + step),
      ArrowRight: () => this.moveTo(x, y - step),
      q: () => this.turn(5),
      e: () => this.turn(-5),
    };
    const action = keys[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  draw(): void {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    const pen = canvas.getContext('2d')!;
    pen.scale(ratio, ratio);
    pen.font = '12px system-ui, sans-serif';
    this.drawRings(pen);
    this.drawCamera(pen);
    this.drawSpeaker(pen);
    this.drawYou(pen);
  }

  private drawRings(pen: CanvasRenderingContext2D): void {
    pen.strokeStyle = colour('--line');
    pen.fillStyle = colour('--faint');
    const [cx, cy] = this.toPage(0, 0);
    for (let r = 1; r <= REACH_M; ++r) {
      pen.beginPath();
      pen.arc(cx, cy, r * this.scale, 0, 2 * Math.PI);
      pen.stroke();
      pen.fillText(`${r} m`, cx + 3, cy + r * this.scale - 3);
    }
  }

  private drawCamera(pen: CanvasRenderingContext2D): void {
    const [cx, cy] = this.toPage(0, 0);
    const half = (this.clip.fov_deg * Math.PI) / 360;
    pen.globalAlpha = 0.12;
    pen.fillStyle = colour('--ink');
    pen.beginPath();
    pen.moveTo(cx, cy);
    pen.arc(cx, cy, REACH_M * this.scale, -Math.PI / 2 - half, -Math.PI / 2 + half);
    pen.fill();
    pen.globalAlpha = 1;
    pen.fillRect(cx - 6, cy - 6, 12, 12);
    pen.fillText('camera', cx + 10, cy + 4);
  }

  private drawSpeaker(pen: CanvasRenderingContext2D): void {
    const { position_m, told } = this.clip.speaker;
    const [x, y] = this.toPage(position_m[0], position_m[1]);
    pen.fillStyle = colour('--speaker');
    pen.beginPath();
    pen.arc(x, y, 8, 0, 2 * Math.PI);
    pen.fill();
    pen.fillText(told ? 'speaker' : 'speaker, as found', x + 12, y + 4);
  }

  private drawYou(pen: CanvasRenderingContext2D): void {
    const [x, y] = this.toPage(this.pose.x, this.pose.y);
    const yaw = (this.pose.yaw_deg * Math.PI) / 180;
    const ahead = [-Math.sin(yaw), -Math.cos(yaw)];
    pen.fillStyle = pen.strokeStyle = colour('--you');
    pen.lineWidth = 3;
    pen.beginPath();
    pen.arc(x, y, 10, 0, 2 * Math.PI);
    pen.fill();
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + 22 * ahead[0], y + 22 * ahead[1]);
    pen.stroke();
    pen.lineWidth = 1;
    pen.fillText('you', x + 14, y + 18);
  }
}
