/** A step as the server describes it; it does not reveal the methods behind the sounds. */
export interface Step {
  kind: 'headphones' | 'training' | 'trial';
  scale: '' | 'place' | 'timbre';
  sounds: number;
  revision?: number;
  choice?: number;
  ratings?: number[];
}

export interface State {
  design: 'choice' | 'mushra';
  title: string;
  simulated: string;
  passed_headphones: boolean;
  finished: boolean;
  at: number;
  steps: Step[];
}

export interface About {
  title: string;
  design: 'choice' | 'mushra';
  clips: number;
}

export interface Given {
  choice?: number;
  ratings?: number[];
}

/** A refusal by the server, with its HTTP status. */
export class Refusal extends Error {
  constructor(readonly status: number, message: string) {
    super(message);
  }
}

async function checked(response: Response): Promise<Response> {
  if (response.ok) return response;
  const told = await response.json().catch(() => ({}));
  throw new Refusal(response.status, told.error ?? `the server answered ${response.status}`);
}

async function post(path: string, body: object): Promise<Response> {
  const headers = { 'Content-Type': 'application/json' };
  return checked(await fetch(path, { method: 'POST', headers, body: JSON.stringify(body) }));
}

export async function fetchAbout(): Promise<About> {
  return (await checked(await fetch('/api/study'))).json();
}

export async function join(label: string): Promise<string> {
  return (await (await post('/api/participants', { label })).json()).participant;
}

/** The requests of one participant. */
export class Desk {
  constructor(readonly participant: string) {}

  async state(): Promise<State> {
    return (await checked(await fetch(this.path('')))).json();
  }
  async answer(step: number, revision: number, given: Given, seconds: number): Promise<void> {
    await post(this.path(`/steps/${step}`), { ...given, revision, seconds });
  }
  async finish(comment: string): Promise<void> {
    await post(this.path('/finish'), { comment });
  }
  picture(step: number): string {
    return this.path(`/steps/${step}/picture`);
  }
  async sound(step: number, sound: string): Promise<ArrayBuffer> {
    return (await checked(await fetch(this.path(`/steps/${step}/sounds/${sound}`)))).arrayBuffer();
  }

  private path(rest: string): string {
    return `/api/participants/${this.participant}${rest}`;
  }
}
