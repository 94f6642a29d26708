// Numbers with units, as people write them.

const MINUS = "−";

/** Four significant digits, with a true minus and no exponent where it can be avoided. */
export function number(value, digits = 4) {
  if (value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6)) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    const power = [...String(Number(exponent))].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"["0123456789".indexOf(digit)] ?? "⁻").join("");
    return `${mantissa.replace("-", MINUS)} × 10${power}`;
  }
  return String(Number(value.toPrecision(digits))).replace("-", MINUS);
}

export const percent = (fraction, digits = 3) => `${number(100 * fraction, digits)} %`;

/** A deviation, always with its sign. */
export const signed = (fraction) => (fraction > 0 ? "+" : "") + percent(fraction);

/** A value in the first unit, of [name, size, used from], that it is large enough for; else in the last. */
function scaled(value, units) {
  if (value === 0) return "0";
  const [unit, size] = units.find(([, , from]) => Math.abs(value) >= from) ?? units[units.length - 1];
  return `${number(value / size)} ${unit}`;
}

export const length = (micrometres) => scaled(micrometres, [["mm", 1e3, 1e3], ["µm", 1, 1], ["nm", 1e-3, 0]]);

export const area = (squareMillimetres) => scaled(squareMillimetres, [["mm²", 1, 1e-2], ["µm²", 1e-6, 0]]);

export const resistance = (ohm) =>
  scaled(ohm, [["MΩ", 1e6, 1e6], ["kΩ", 1e3, 1e3], ["Ω", 1, 1], ["mΩ", 1e-3, 1e-3], ["µΩ", 1e-6, 1e-6], ["nΩ", 1e-9, 0]]);

export const duration = (milliseconds) => scaled(milliseconds, [["s", 1e3, 1e3], ["ms", 1, 0]]);

/** A score between 0 and 1. */
export const score = (value) => value.toFixed(4);
