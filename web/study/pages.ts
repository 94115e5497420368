import { Desk, Given, Step } from './desk';
import { make } from './elements';
import { Sounds } from './sounds';

const NAMES = 'ABCDEFGHIJ';

const QUESTIONS: Record<string, [string, string]> = {
  '': ['Which sound is closest to the reference?',
    'The picture shows what the listener sees; the reference is the true sound there. Listen to all sounds.'],
  place: ['How close is the position of the voice?',
    'Rate where the voice comes from and how far away it is, compared with the reference. '
    + 'One of the sounds is the reference itself and deserves 100. Do not rate the tone colour here.'],
  timbre: ['How close is the tone colour?',
    'Rate tone colour and room, compared with the reference. One of the sounds is the reference itself and deserves 100. '
    + 'Do not rate where the voice comes from here.'],
};

/** A page that gives an answer once it is complete. */
export interface Page {
  root: HTMLElement;
  /** Undefined while the answer is incomplete. */
  given(): Given | undefined;
  onchange: () => void;
  sounds: Sounds;
}

interface Row {
  root: HTMLElement;
  play: HTMLButtonElement;
  name: string;
}

function playRow(sounds: Sounds, name: string, text: string, ...controls: HTMLElement[]): Row {
  const play = make('button', { type: 'button', className: 'play', textContent: `Play ${text}` });
  play.onclick = () => void sounds.toggle(name);
  return { root: make('div', { className: 'sound' }, play, ...controls), play, name };
}

/** Marks the sound that plays, and the sounds that were heard to their end. */
function follow(sounds: Sounds, rows: Row[], onheard: (name: string) => void): void {
  sounds.onplaying = (name) => {
    for (const row of rows) row.play.classList.toggle('playing', row.name === name);
  };
  sounds.onheard = (name) => {
    rows.find((row) => row.name === name)?.play.classList.add('heard');
    onheard(name);
  };
}

export function headphonePage(context: AudioContext): Page {
  const sounds = new Sounds(context);
  let choice: number | undefined;
  let heard = false;
  const row = playRow(sounds, '0', 'the tones');
  const choices = [1, 2, 3].map((tone) => {
    const radio = make('input', { type: 'radio', name: 'tone', disabled: true });
    radio.onchange = () => { choice = tone - 1; page.onchange(); };
    return { radio, label: make('label', {}, radio, ['The first', 'The second', 'The third'][tone - 1]) };
  });
  follow(sounds, [row], () => {
    heard = true;
    for (const { radio } of choices) radio.disabled = false;
    page.onchange();
  });
  const page: Page = {
    root: make('div', {},
      make('h2', { textContent: 'Which of the three tones is the quietest?' }),
      make('p', { className: 'hint', textContent: 'This checks that you listen with headphones. Play the tones as often as you like.' }),
      make('div', { className: 'sounds' }, row.root,
        make('div', { className: 'sound', role: 'radiogroup' }, ...choices.map(({ label }) => label)))),
    given: () => (heard && choice !== undefined ? { choice } : undefined),
    onchange: () => {},
    sounds,
  };
  return page;
}

/** The target's picture and true sound, and the sounds to compare. */
export function trialPage(context: AudioContext, desk: Desk, number: number, step: Step): Page {
  const sounds = new Sounds(context);
  const heard = new Set<string>();
  const reference = playRow(sounds, 'reference', 'reference');
  let choice = step.choice;
  const ratings: (number | undefined)[] = Array.from({ length: step.sounds }, (_, i) => step.ratings?.[i]);
  const rows = Array.from({ length: step.sounds }, (_, i) => {
    const control = step.scale === '' ? chooser(i) : slider(i);
    return playRow(sounds, String(i), NAMES[i], control);
  });
  follow(sounds, [reference, ...rows], (name) => { heard.add(name); page.onchange(); });

  function chooser(i: number): HTMLElement {
    const radio = make('input', { type: 'radio', name: 'closest', checked: choice === i });
    radio.onchange = () => {
      choice = i;
      rows.forEach((row, k) => row.root.classList.toggle('chosen', k === i));
      page.onchange();
    };
    return make('label', {}, radio, `${NAMES[i]} is closest`);
  }
  function slider(i: number): HTMLElement {
    const text = make('output', { textContent: ratings[i] ?? '–' });
    const range = make('input', { type: 'range', min: '0', max: '100', step: '1', value: String(ratings[i] ?? 50) });
    range.setAttribute('aria-label', `Rating of ${NAMES[i]}`);
    range.oninput = () => {
      ratings[i] = Number(range.value);
      text.textContent = range.value;
      page.onchange();
    };
    return make('label', {}, range, text);
  }

  const [question, hint] = QUESTIONS[step.scale];
  const picture = make('img', { className: 'picture', src: desk.picture(number), alt: 'What the listener sees' });
  const scale = make('div', { className: 'scale' },
    ...['0 bad', '20 poor', '40 fair', '60 good', '80 excellent 100'].map((name) => make('span', { textContent: name })));
  const answered = step.revision !== undefined;
  const page: Page = {
    root: make('div', {},
      make('h2', { textContent: question }), make('p', { className: 'hint', textContent: hint }), picture,
      make('div', { className: 'sounds' }, reference.root, ...rows.map((row) => row.root), ...(step.scale === '' ? [] : [scale])),
      make('p', { className: 'hint', textContent: 'Keys: R plays the reference, A, B, C … the sounds; a second press stops.' })),
    given: () => {
      if (!answered && heard.size < step.sounds + 1) return undefined;
      if (step.scale === '') return choice === undefined ? undefined : { choice };
      return ratings.every((rating) => rating !== undefined) ? { ratings: ratings as number[] } : undefined;
    },
    onchange: () => {},
    sounds,
  };
  if (choice !== undefined) rows[choice]?.root.classList.add('chosen');
  return page;
}

/** The sound that a key plays, if any. */
export function soundOfKey(key: string, step: Step): string | undefined {
  if (step.kind === 'headphones') return undefined;
  if (key.toUpperCase() === 'R') return 'reference';
  const place = NAMES.indexOf(key.toUpperCase());
  return key.length === 1 && place >= 0 && place < step.sounds ? String(place) : undefined;
}
