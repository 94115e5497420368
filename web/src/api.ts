/** What the server says about a clip: GET /api/clips/ID. Metres; x front, y left, z up. */
export interface Clip {
  id: string;
  name: string;
  duration_s: number;
  sample_rate_hz: number;
  samples: number;
  has_picture: boolean;
  has_movie: boolean;
  fov_deg: number;
  /** `browser`: what the page's own engine needs for it; without it only the server renders the method. */
  methods: { name: string; missing?: string; browser?: 'recording' | 'model' }[];
  warnings: string[];
  people: { box: [number, number, number, number]; speaks: boolean }[];
  places: { name: string; position_m: [number, number, number]; yaw_deg: number }[];
  /** What methods are told: where the speaker is seen in the picture, and where their mouth is. */
  speaker_box?: [number, number, number, number];
  speaker_m?: [number, number, number];
  /** What is shown: told or found. */
  speaker?: { position_m: [number, number, number]; told: boolean; heading_deg: number; spread_deg: number };
  map?: { camera_px: [number, number]; pixels_per_metre: number };
  plan?: { rooms: [number, number][][]; doors: [number, number][][] };
}

export interface ClipList {
  clips: { id: string; name: string }[];
  most_upload_bytes: number;
  has_engine: boolean;
}

/** Pose of the listener's head: metres in the source camera's frame; a positive yaw turns left. */
export interface Pose {
  x: number;
  y: number;
  z: number;
  yaw_deg: number;
}

/** What a request for a part of the sound specifies. */
export interface Wish {
  pose: Pose;
  method: string;
  matches_level: boolean;
}

export class ServerError extends Error {
  constructor(readonly status: number, message: string) {
    super(message);
  }
}

async function checked(response: Response): Promise<Response> {
  if (response.ok) return response;
  const told = await response.json().catch(() => ({}));
  throw new ServerError(response.status, told.error ?? `the server answered ${response.status}`);
}

const post = async (address: string, body?: BodyInit) => checked(await fetch(address, { method: 'POST', body }));

export async function fetchClips(): Promise<ClipList> {
  return (await checked(await fetch('/api/clips'))).json();
}

export async function fetchClip(id: string): Promise<Clip> {
  return { ...(await (await checked(await fetch(`/api/clips/${id}`))).json()), id };
}

/** Uploads a recording. @returns the id of its clip */
export async function sendClip(file: File): Promise<string> {
  return (await (await post(`/api/clips?name=${encodeURIComponent(file.name)}`, file)).json()).clip;
}

/** All of the recording: left and right ear. */
export async function fetchRecording(clip: string): Promise<Float32Array[]> {
  const both = new Float32Array(await (await checked(await fetch(`/api/clips/${clip}/sound`))).arrayBuffer());
  return [both.slice(0, both.length / 2), both.slice(both.length / 2)];
}

/** What the engine opens for a method. */
export async function fetchModel(method: string): Promise<Uint8Array> {
  const response = await checked(await fetch(`/api/model?method=${encodeURIComponent(method)}`));
  return new Uint8Array(await response.arrayBuffer());
}

export async function fetchEngine(): Promise<ArrayBuffer> {
  return (await checked(await fetch('/engine.wasm'))).arrayBuffer();
}

export async function fetchPicture(clip: string): Promise<Blob> {
  return (await checked(await fetch(`/api/clips/${clip}/picture`))).blob();
}

export async function joinAsListener(clip: string): Promise<string> {
  return (await (await post('/api/listeners', JSON.stringify({ clip }))).json()).listener;
}

/** Makes room for another listener, also while the page is being closed. */
export function leave(listener: string): void {
  navigator.sendBeacon(`/api/listeners/${listener}/leave`);
}

/** The sound from sample `start` on, left and right interleaved. */
export async function fetchSound(listener: string, start: number, samples: number, wish: Wish): Promise<Float32Array> {
  const { pose, method, matches_level } = wish;
  const body = JSON.stringify({
    start, samples, method, matches_level, position_m: [pose.x, pose.y, pose.z], yaw_deg: pose.yaw_deg,
  });
  return new Float32Array(await (await post(`/api/listeners/${listener}/sound`, body)).arrayBuffer());
}

/** A walk, rendered as by `earpoint render --path`. */
export async function renderWalk(clip: string, method: string, format: string, csv: string): Promise<Blob> {
  const query = `method=${encodeURIComponent(method)}&format=${format}`;
  return (await post(`/api/clips/${clip}/walk?${query}`, csv)).blob();
}
