import type { Pose } from './api';

/** How long the head takes to a new pose: steps of the pointer join to one movement. */
const WAY_S = 0.03;

const between = (a: number, b: number, share: number) => a + share * (b - a);

/** The shorter way round from one heading to another. */
const turn = (from_deg: number, to_deg: number) => ((to_deg - from_deg + 540) % 360) - 180;

/** The pose at a share, from 0 to 1, of the way from one pose to another. */
export function onTheWay(a: Pose, b: Pose, share: number): Pose {
  return {
    x: between(a.x, b.x, share),
    y: between(a.y, b.y, share),
    z: between(a.z, b.z, share),
    yaw_deg: a.yaw_deg + share * turn(a.yaw_deg, b.yaw_deg),
  };
}

/** A head that moves evenly from where it is to the last pose that it was given. */
export class Motion {
  pose: Pose = { x: 0, y: 0, z: 0, yaw_deg: 0 };
  private from = this.pose;
  private to = this.pose;
  private done = 1; // share of the way

  constructor(private readonly rate_hz: number) {}

  set(to: Pose): void {
    this.from = this.pose;
    this.to = { ...to };
    this.done = 0;
  }

  /** Is there at once. */
  arrive(): void {
    this.pose = this.to;
    this.done = 1;
  }

  /** @returns whether the pose has changed in these samples */
  advance(samples: number): boolean {
    if (this.done >= 1) return false;
    this.done = Math.min(1, this.done + samples / (WAY_S * this.rate_hz));
    this.pose = this.done < 1 ? onTheWay(this.from, this.to, this.done) : this.to;
    return true;
  }
}
