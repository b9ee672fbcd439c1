// Elements of the page: found, made, and changed only where they differ, so that nothing flickers or loses its focus.

export const element = id => document.getElementById(id);

// Makes an element; properties that HTML writes with a dash are attributes.
export function make(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name.includes('-') || name === 'role' || name === 'for') made.setAttribute(name, value);
    else made[name] = value;
  }
  made.append(...children.flat().filter(child => child !== null && child !== undefined));
  return made;
}

const SVG = 'http://www.w3.org/2000/svg';

export function makeSvg(tag, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children.flat());
  return made;
}

// Puts other children into an element. Who went through the old ones by keys goes on at the one with the same id.
export function replaceChildren(target, children) {
  const focused = target.contains(document.activeElement) ? document.activeElement.id : '';
  target.replaceChildren(...children);
  if (focused) element(focused)?.focus();
}

export function setText(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

export function setHidden(target, isHidden) {
  if (target.hidden !== isHidden) target.hidden = isHidden;
}

// A field with its label and, where there is one, a line of help.
export function field(label, control, help) {
  control.id ||= `field-${++fields}`;
  const hint = help ? make('small', { id: `${control.id}-help` }, help) : null;
  if (hint) control.setAttribute('aria-describedby', hint.id);
  return make('p', { className: 'field' }, make('label', { for: control.id }, label), control, hint);
}

let fields = 0;
