// Colours that red-green blindness leaves apart (Okabe and Ito); views differ in their lines, too: whole in view, dashed out of it.
const robots = {
  light: ['#0072b2', '#b85c00', '#007a5a', '#a3457d', '#3f63c9', '#7a6a00'],
  dark: ['#56b4e9', '#e69f00', '#2fc49a', '#e39ac4', '#8fa8ff', '#f0e442'],
};
const rest = {
  light: { back: '#eef1f5', grid: '#c3cad3', good: '#008f4c', bad: '#cc1f1a', grey: '#68707c', text: '#1c2127', edge: '#d5dae1' },
  dark: { back: '#14181d', grid: '#3a424c', good: '#35c77f', bad: '#ff6b5e', grey: '#98a2ae', text: '#e6e9ed', edge: '#363d46' },
};

export const theme = () => document.documentElement.dataset.theme;
export const robotColour = (i) => robots[theme()][i % robots[theme()].length];
export const colours = () => rest[theme()];

export function chooseTheme(name) {
  document.documentElement.dataset.theme = name;
}
export const systemTheme = () => (matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light');
