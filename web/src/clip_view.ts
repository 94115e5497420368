import { Clip, ClipList, sendClip } from './api';

const HIGHEST_VH = 42; // of the picture, in hundredths of the window

export function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

export function tell(what: string): void {
  element('problem').textContent = what;
}

function personBox({ box, speaks }: Clip['people'][number]): HTMLElement {
  const frame = document.createElement('div');
  frame.className = speaks ? 'box speaks' : 'box';
  const [x0, y0, x1, y1] = box.map((n) => 100 * n);
  Object.assign(frame.style, { left: `${x0}%`, top: `${y0}%`, width: `${x1 - x0}%`, height: `${y1 - y0}%` });
  if (speaks) {
    const label = document.createElement('span');
    label.textContent = 'speaks';
    frame.append(label);
  }
  return frame;
}

/** The clip's picture with the people in it, and what was assumed. */
export function showClip(clip: Clip): void {
  document.title = `${clip.name} - Earpoint`;
  element('name').textContent = `${clip.name}, ${clip.duration_s.toFixed(1)} s`;
  const picture = element<HTMLImageElement>('picture');
  // Limits the height, so that there is room for the sound below.
  picture.onload = () => {
    element('picture-frame').style.maxWidth = `${(HIGHEST_VH * picture.naturalWidth) / picture.naturalHeight}vh`;
  };
  if (clip.has_picture) picture.src = `/api/clips/${clip.id}/picture`;
  picture.hidden = !clip.has_picture;
  element('no-picture').hidden = clip.has_picture;
  element('picture-frame').append(...clip.people.map(personBox));
  for (const warning of clip.warnings) {
    const item = document.createElement('li');
    item.textContent = warning;
    element('warnings').append(item);
  }
}

/** Opens another clip, rendered as the address has it for this one. */
function go(clip: string): void {
  const query = new URLSearchParams(location.search);
  query.set('clip', clip);
  location.assign(`/?${query}`);
}

/** Shows the list of clips and, if the server accepts files, the control that opens one. */
export function showChoice(list: ClipList, chosen: string | undefined): void {
  const clips = element<HTMLSelectElement>('clips');
  for (const { id, name } of list.clips) clips.append(new Option(name, id, false, id === chosen));
  if (!list.clips.some(({ id }) => id === chosen)) clips.selectedIndex = -1;
  clips.onchange = () => go(clips.value);
  const isOwn = chosen !== undefined && !list.clips.some(({ id }) => id === chosen);
  element('choice').hidden = list.clips.length < (isOwn ? 1 : 2);
  if (list.most_upload_bytes > 0) takeFiles(list.most_upload_bytes);
}

function takeFiles(most_bytes: number): void {
  const take = async (file: File | undefined) => {
    if (!file) return;
    if (file.size > most_bytes) {
      tell(`${file.name} is larger than ${Math.floor(most_bytes / 2 ** 20)} MB.`);
      return;
    }
    element('name').textContent = `reading ${file.name}`;
    try {
      go(await sendClip(file));
    } catch (error) {
      element('name').textContent = '';
      tell((error as Error).message);
    }
  };
  element('own').hidden = false;
  const input = element<HTMLInputElement>('file');
  input.onchange = () => void take(input.files?.[0]);
  const shown = element('drop');
  addEventListener('dragover', (event) => {
    event.preventDefault();
    shown.hidden = false;
  });
  addEventListener('dragleave', (event) => {
    if (!event.relatedTarget) shown.hidden = true;
  });
  addEventListener('drop', (event) => {
    event.preventDefault();
    shown.hidden = true;
    void take(event.dataTransfer?.files[0]);
  });
}
