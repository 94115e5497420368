/** What the server tells of its clip: GET /api/clip. Metres; x front, y left, z up. */
export interface Clip {
  name: string;
  duration_s: number;
  sample_rate_hz: number;
  samples: number;
  has_picture: boolean;
  fov_deg: number;
  methods: string[];
  warnings: string[];
  box?: [number, number, number, number];
  speaker: { position_m: [number, number, number]; told: boolean; heading_deg: number; spread_deg: number };
}

/** Where a head is: metres in the source camera's frame; a positive yaw turns left. */
export interface Pose {
  x: number;
  y: number;
  z: number;
  yaw_deg: number;
}

async function checked(response: Response): Promise<Response> {
  if (response.ok) return response;
  const told = await response.json().catch(() => ({}));
  throw new Error(told.error ?? `the server answered ${response.status}`);
}

export async function fetchClip(): Promise<Clip> {
  return (await checked(await fetch('/api/clip'))).json();
}

export async function joinAsListener(): Promise<string> {
  const answer = await checked(await fetch('/api/listeners', { method: 'POST' }));
  return (await answer.json()).listener;
}

/** The sound from sample `start` on, left and right in turns. */
export async function fetchSound(
  listener: string, start: number, samples: number, pose: Pose, method: string,
): Promise<Float32Array> {
  const body = JSON.stringify({
    start, samples, method, position_m: [pose.x, pose.y, pose.z], yaw_deg: pose.yaw_deg,
  });
  const answer = await checked(await fetch(`/api/listeners/${listener}/sound`, { method: 'POST', body }));
  return new Float32Array(await answer.arrayBuffer());
}
