import { About, Desk, Given, Refusal, State, fetchAbout, join } from './desk';
import { byId, make } from './elements';
import { Page, headphonePage, soundOfKey, trialPage } from './pages';

const STORED = 'earpoint-study-participant';

function show(...children: (Node | string)[]): void {
  const page = byId('page');
  page.replaceChildren(...children);
  window.scrollTo(0, 0);
}

function tell(problem: unknown): void {
  byId('problem').textContent = problem ? (problem as Error).message : '';
}

/** A button that starts a new participant. */
function startButton(text: string): HTMLButtonElement {
  const button = make('button', { type: 'button', textContent: text });
  button.onclick = () => { localStorage.removeItem(STORED); location.reload(); };
  return button;
}

/** Leads a participant from step to step. */
class Study {
  private readonly context = new AudioContext();
  private state?: State;
  private step = 0;
  private page?: Page;
  private shown = 0;
  private sending = false;

  constructor(private readonly desk: Desk) {
    document.addEventListener('keydown', (event) => this.onKey(event));
  }

  /** Goes to the participant's present step. */
  async begin(): Promise<void> {
    this.state = await this.desk.state();
    byId('title').textContent = this.state.title;
    const simulated = byId('simulated');
    simulated.hidden = this.state.simulated === '';
    simulated.textContent = `Simulated participant (${this.state.simulated})`;
    await this.go(this.state.at);
  }

  private async go(step: number): Promise<void> {
    tell('');
    const state = this.state!;
    this.page?.sounds.stop();
    this.page = undefined;
    this.step = step;
    byId<HTMLProgressElement>('progress').value = state.at / state.steps.length;
    if (!state.passed_headphones) return this.showFailed();
    if (state.finished) return this.showThanks();
    if (step >= state.steps.length) return this.showEnd();
    const kind = state.steps[step].kind;
    const trials = state.steps.filter((s) => s.kind === 'trial');
    const before = state.steps.slice(0, step).filter((s) => s.kind === 'trial').length;
    byId('progress-text').textContent = kind === 'headphones' ? `Headphone check ${step + 1}`
      : kind === 'training' ? 'Practice, this answer does not count' : `Question ${before + 1} of ${trials.length}`;
    await this.showStep(step);
  }

  private async showStep(number: number): Promise<void> {
    const step = this.state!.steps[number];
    const page = step.kind === 'headphones' ? headphonePage(this.context) : trialPage(this.context, this.desk, number, step);
    const next = make('button', { id: 'next', type: 'button', className: 'main', textContent: 'Next', disabled: true });
    const back = make('button', { id: 'back', type: 'button', textContent: 'Back', disabled: !this.canGoBack(number) });
    next.onclick = () => void this.send();
    back.onclick = () => void this.go(number - 1);
    page.onchange = () => { next.disabled = !page.given(); };
    show(page.root, make('div', { className: 'buttons' }, back, next));
    const names = step.kind === 'headphones' ? ['0'] : ['reference', ...Array.from({ length: step.sounds }, (_, i) => String(i))];
    await Promise.all(names.map(async (name) => page.sounds.load(name, await this.desk.sound(number, name))));
    this.page = page;
    this.shown = performance.now();
    page.onchange();
  }

  private canGoBack(step: number): boolean {
    return step > 0 && this.state!.steps[step - 1].kind !== 'headphones';
  }

  /** Stores the answer, then goes on; if the network fails, stays on the page and says so. */
  private async send(): Promise<void> {
    const given = this.page?.given();
    if (!given || this.sending) return;
    this.sending = true;
    try {
      if (this.isChanged(given)) {
        const step = this.state!.steps[this.step];
        const revision = step.revision === undefined ? 0 : step.revision + 1;
        await this.desk.answer(this.step, revision, given, (performance.now() - this.shown) / 1000);
      }
      this.state = await this.desk.state();
      await this.go(this.step + 1);
    } catch (error) {
      await this.recover(error);
    } finally {
      this.sending = false;
    }
  }

  private isChanged(given: Given): boolean {
    const step = this.state!.steps[this.step];
    return JSON.stringify([step.choice, step.ratings]) !== JSON.stringify([given.choice, given.ratings]);
  }

  /** If the answer exists already, for example from another tab, goes to the participant's present step. */
  private async recover(error: unknown): Promise<void> {
    if (!(error instanceof Refusal) || error.status !== 409) return tell(error);
    await this.begin();
    tell(error);
  }

  private showFailed(): void {
    byId('progress-text').textContent = '';
    const again = startButton('Start again with headphones');
    show(make('h2', { textContent: 'The headphone check did not work' }),
      make('p', { textContent: 'This study needs headphones with a left and a right side. Put them on, switch off effects such as '
        + 'surround or mono, and start again.' }), again);
  }

  private showEnd(): void {
    byId('progress-text').textContent = 'All questions are answered';
    const comment = make('textarea', { id: 'comment', rows: 4, maxLength: 1900 });
    comment.setAttribute('aria-label', 'Remarks');
    const back = make('button', { type: 'button', textContent: 'Back' });
    back.onclick = () => void this.go(this.step - 1);
    const end = make('button', { id: 'finish', type: 'button', className: 'main', textContent: 'Finish' });
    end.onclick = async () => {
      try {
        await this.desk.finish(comment.value);
        this.state = await this.desk.state();
        await this.go(this.step);
      } catch (error) {
        await this.recover(error);
      }
    };
    show(make('h2', { textContent: 'Any remarks?' }),
      make('p', { className: 'hint', textContent: 'After this, answers can no longer be changed.' }), comment,
      make('div', { className: 'buttons' }, back, end));
  }

  private showThanks(): void {
    byId('progress-text').textContent = '';
    show(make('h2', { textContent: 'Thank you' }), make('p', { textContent: 'Your answers are stored. You can close this page.' }),
      make('div', { className: 'buttons' }, make('span'), startButton('Another person takes part')));
  }

  private onKey(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (!this.page || event.ctrlKey || event.metaKey || event.altKey || target.tagName === 'TEXTAREA') return;
    const sound = soundOfKey(event.key, this.state!.steps[this.step]);
    if (sound !== undefined) void this.page.sounds.toggle(sound);
  }
}

function showWelcome(about: About): void {
  byId('title').textContent = about.title;
  const label = make('input', { type: 'text', id: 'label', maxLength: 60 });
  const start = make('button', { id: 'start', type: 'button', className: 'main', textContent: 'Start' });
  const given = new URLSearchParams(location.search).get('participant');
  if (given) label.value = given;
  start.onclick = async () => {
    try {
      const participant = await join(label.value.trim());
      localStorage.setItem(STORED, participant);
      await new Study(new Desk(participant)).begin();
    } catch (error) {
      tell(error);
    }
  };
  show(make('h2', { textContent: 'A listening study' }),
    make('p', { textContent: 'You will hear short recordings of a voice and compare them with a reference. '
      + `There are ${about.clips} recordings; answers are stored one by one, and you can close the page and come back on this device.` }),
    make('p', { textContent: 'Please use headphones in a quiet place, the left side on the left ear, and set a comfortable volume '
      + 'with the first tones. Leave it as it is afterwards.' }),
    make('label', {}, 'Your code, if you were given one ', label),
    make('p', { className: 'hint', textContent: 'Only your answers, how long they took, and what you write here are stored.' }),
    make('div', { className: 'buttons' }, make('span'), start));
}

async function main(): Promise<void> {
  const about = await fetchAbout();
  const stored = localStorage.getItem(STORED);
  if (stored) {
    try {
      return await new Study(new Desk(stored)).begin();
    } catch (error) {
      if (!(error instanceof Refusal) || error.status !== 404) throw error;
      localStorage.removeItem(STORED); // of another study
    }
  }
  showWelcome(about);
}

main().catch(tell);
