// Tags as people write them: separated by commas. A pure function.
export const readTags = text => [
  ...new Set(
    text
      .split(',')
      .map(tag => tag.trim())
      .filter(Boolean),
  ),
];
