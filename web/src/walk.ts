import { Pose } from './api';
import { onTheWay } from './motion';

/** The listener's pose at a time of the clip. */
export interface Step extends Pose {
  time_s: number;
}

/** A walk through a clip from its beginning to its end. */
export class Walk {
  private readonly steps: Step[] = [];

  constructor(private readonly duration_s: number) {}

  /** A step whose time does not increase is left out. */
  add(step: Step): void {
    const last = this.steps[this.steps.length - 1];
    if (!last || step.time_s > last.time_s) this.steps.push({ ...step });
  }

  get isEmpty(): boolean {
    return this.steps.length === 0;
  }

  at(time_s: number): Pose {
    const after = this.steps.findIndex((step) => step.time_s >= time_s);
    if (after < 0) return this.steps[this.steps.length - 1];
    if (after === 0) return this.steps[0];
    const [a, b] = [this.steps[after - 1], this.steps[after]];
    const share = (time_s - a.time_s) / (b.time_s - a.time_s);
    return onTheWay(a, b, share);
  }

  /** For `earpoint render --path`. Covers the whole clip: the listener stands still before and after the steps. */
  csv(): string {
    const rows = [...this.steps];
    if (rows[0].time_s > 0) rows.unshift({ ...rows[0], time_s: 0 });
    const last = rows[rows.length - 1];
    if (last.time_s < this.duration_s - 1e-3) rows.push({ ...last, time_s: this.duration_s });
    const lines = rows.map((s) => [s.time_s, s.x, s.y, s.z, s.yaw_deg, 0, 0].map((n) => n.toFixed(4)).join(','));
    return ['time_s,x,y,z,yaw_deg,pitch_deg,roll_deg', ...lines, ''].join('\n');
  }
}
