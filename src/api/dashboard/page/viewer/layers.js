// The layers of a picture, in the order of the digit keys.

export const LAYERS = [
  { name: 'color', label: 'Color', kind: 'color', unit: 'W/(sr·m²)' },
  { name: 'radius', label: 'Radius', kind: 'scale', unit: 'm' },
  { name: 'photons', label: 'Photons', kind: 'scale', unit: '' },
  { name: 'error', label: 'Error', kind: 'scale', unit: 'W/(sr·m²)' },
  { name: 'albedo', label: 'Albedo', kind: 'color', unit: '' },
  { name: 'normal', label: 'Normal', kind: 'normal', unit: '' },
  { name: 'depth', label: 'Depth', kind: 'scale', unit: 'm' },
  { name: 'denoised', label: 'Denoised', kind: 'color', unit: 'W/(sr·m²)' },
  { name: 'denoised_error', label: 'Its error', kind: 'scale', unit: 'W/(sr·m²)' },
  // Of jobs that keep them apart; no digit is left for it.
  { name: 'light_groups', label: 'Light groups', kind: 'color', unit: 'W/(sr·m²)' },
];

export const layerNamed = name => LAYERS.find(layer => layer.name === name);

// What a channel is called beside its value: `R`, `Y`.
export const channelLetter = channel => channel.split('.').pop();
