import { Clip, Pose } from './api';

const REACH_M = 5; // the largest move that the network was trained on
const STEP_M = 0.1;
const STEP_DEGREES = 5;
const STEP_UP_M = 0.05;
const HIGHEST_M = 0.3;
const SNAP_PIXELS = 14; // a click this close to a known place goes there

export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

const clamp = (value: number, most: number) => Math.max(-most, Math.min(most, value));

/** The scene from above, with the camera's front up. The listener can be dragged. */
export class SceneMap {
  readonly pose: Pose = { x: 0, y: 0, z: 0, yaw_deg: 0 };
  onmove: () => void = () => {};
  private readonly picture?: HTMLImageElement; // of the scene from above

  constructor(private readonly canvas: HTMLCanvasElement, private readonly clip: Clip) {
    if (clip.map) {
      this.picture = new Image();
      this.picture.onload = () => this.draw();
      this.picture.src = `/api/clips/${clip.id}/map`;
    }
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      if (!this.snap(event)) this.drag(event);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons) this.drag(event);
    });
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.turn(event.deltaY > 0 ? -STEP_DEGREES : STEP_DEGREES);
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
  }

  moveTo(x: number, y: number): void {
    this.set({ ...this.pose, x, y });
  }

  turn(by_deg: number): void {
    this.set({ ...this.pose, yaw_deg: this.pose.yaw_deg + by_deg });
  }

  rise(by_m: number): void {
    this.set({ ...this.pose, z: this.pose.z + by_m });
  }

  set(pose: Pose): void {
    this.pose.x = clamp(pose.x, REACH_M);
    this.pose.y = clamp(pose.y, REACH_M);
    this.pose.z = clamp(pose.z, HIGHEST_M);
    this.pose.yaw_deg = ((pose.yaw_deg + 540) % 360) - 180;
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

  /** Where a place is drawn, in the page's pixels; by default the listener's. */
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

  /** Goes to a known place that was clicked, and takes its heading. */
  private snap(event: PointerEvent): boolean {
    const place = this.clip.places.find(({ position_m: [x, y] }) => {
      const [across, down] = this.pagePoint(x, y);
      return Math.hypot(event.clientX - across, event.clientY - down) < SNAP_PIXELS;
    });
    if (place) this.goTo(place);
    return place !== undefined;
  }

  goTo({ position_m: [x, y, z], yaw_deg }: Clip['places'][number]): void {
    this.set({ x, y, z, yaw_deg });
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { x, y } = this.pose;
    const keys: Record<string, () => void> = {
      ArrowUp: () => this.moveTo(x + STEP_M, y),
      ArrowDown: () => this.moveTo(x - STEP_M, y),
      ArrowLeft: () => this.moveTo(x, y + STEP_M),
      ArrowRight: () => this.moveTo(x, y - STEP_M),
      q: () => this.turn(STEP_DEGREES),
      e: () => this.turn(-STEP_DEGREES),
      r: () => this.rise(STEP_UP_M),
      f: () => this.rise(-STEP_UP_M),
    };
    const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
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
    this.drawPicture(pen);
    this.drawPlan(pen);
    this.drawRings(pen);
    this.drawCamera(pen);
    this.drawSpeaker(pen);
    this.clip.places.forEach((place, i) => this.drawPlace(pen, place, i + 1));
    this.drawYou(pen);
  }

  private outline(pen: CanvasRenderingContext2D, polygon: [number, number][]): void {
    pen.beginPath();
    polygon.forEach(([x, y]) => pen.lineTo(...this.toPage(x, y)));
    pen.closePath();
  }

  private drawPicture(pen: CanvasRenderingContext2D): void {
    const { picture } = this;
    if (!picture?.complete || !this.clip.map) return;
    const { camera_px, pixels_per_metre } = this.clip.map;
    const ratio = this.scale / pixels_per_metre;
    const [cx, cy] = this.toPage(0, 0);
    pen.globalAlpha = 0.55;
    pen.drawImage(picture, cx - ratio * camera_px[0], cy - ratio * camera_px[1],
      ratio * picture.naturalWidth, ratio * picture.naturalHeight);
    pen.globalAlpha = 1;
  }

  /** Rooms and their walls, which are open at doors. */
  private drawPlan(pen: CanvasRenderingContext2D): void {
    const { plan } = this.clip;
    if (!plan) return;
    pen.fillStyle = colour('--ground');
    pen.strokeStyle = colour('--wall');
    pen.lineWidth = 3;
    for (const room of plan.rooms) {
      this.outline(pen, room);
      pen.fill();
      pen.stroke();
    }
    pen.strokeStyle = colour('--ground');
    for (const door of plan.doors) {
      this.outline(pen, door);
      pen.fill();
      pen.stroke();
    }
    pen.lineWidth = 1;
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
    if (!this.clip.speaker) return;
    const { position_m, told } = this.clip.speaker;
    const [x, y] = this.toPage(position_m[0], position_m[1]);
    pen.fillStyle = colour('--speaker');
    pen.beginPath();
    pen.arc(x, y, 8, 0, 2 * Math.PI);
    pen.fill();
    pen.fillText(told ? 'speaker' : 'speaker, estimated', x + 12, y + 4);
  }

  /** With the number on its button, as names would overlap. */
  private drawPlace(pen: CanvasRenderingContext2D, place: Clip['places'][number], number: number): void {
    const [x, y] = this.toPage(place.position_m[0], place.position_m[1]);
    pen.fillStyle = pen.strokeStyle = colour('--ink');
    pen.lineWidth = 2;
    this.drawHead(pen, x, y, place.yaw_deg, 6, false);
    pen.fillText(String(number), x + 10, y - 6);
  }

  private drawYou(pen: CanvasRenderingContext2D): void {
    const [x, y] = this.toPage(this.pose.x, this.pose.y);
    pen.fillStyle = pen.strokeStyle = colour('--you');
    pen.lineWidth = 3;
    this.drawHead(pen, x, y, this.pose.yaw_deg, 10, true);
    pen.fillText('you', x + 14, y + 18);
  }

  private drawHead(
    pen: CanvasRenderingContext2D, x: number, y: number, yaw_deg: number, radius: number, isFilled: boolean,
  ): void {
    const yaw = (yaw_deg * Math.PI) / 180;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    if (isFilled) pen.fill();
    pen.moveTo(x, y);
    pen.lineTo(x - 2.2 * radius * Math.sin(yaw), y - 2.2 * radius * Math.cos(yaw));
    pen.stroke();
    pen.lineWidth = 1;
  }
}
