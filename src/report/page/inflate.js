// Deflated bytes (RFC 1951) inflated, for browsers that cannot: one bit of a code at a time.

/// Bases and extra bits of lengths 257…285 and of distances 0…29 (section 3.2.5).
const LENGTH_BASE = [3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131,
  163, 195, 227, 258];
const LENGTH_EXTRA = [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0];
const DISTANCE_BASE = [1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049,
  3073, 4097, 6145, 8193, 12289, 16385, 24577];
const DISTANCE_EXTRA = [0, 0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 8, 9, 9, 10, 10, 11, 11, 12, 12, 13,
  13];
/// The order of the code lengths' own code lengths (section 3.2.7).
const LENGTHS_ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// A canonical Huffman code: how many codes of each length there are, and the symbols in their order.
function huffman(lengths) {
  const counts = new Uint16Array(16);
  for (const length of lengths) counts[length]++;
  counts[0] = 0;
  const next = new Uint16Array(16);
  for (let length = 1; length < 15; length++) next[length + 1] = next[length] + counts[length];
  const symbols = new Uint16Array(lengths.length);
  lengths.forEach((length, symbol) => {
    if (length > 0) symbols[next[length]++] = symbol;
  });
  return { counts, symbols };
}

/// The `size` bytes that `input` holds.
function inflate(input, size) {
  const output = new Uint8Array(size);
  let [place, written, held, bits] = [0, 0, 0, 0];
  const take = (count) => {
    while (bits < count) {
      if (place >= input.length) throw new Error("the cells' numbers end too early");
      held |= input[place++] << bits;
      bits += 8;
    }
    const value = held & ((1 << count) - 1);
    held >>>= count;
    bits -= count;
    return value;
  };
  const symbol = ({ counts, symbols }) => {
    let [code, first, index] = [0, 0, 0];
    for (let length = 1; length < 16; length++) {
      code |= take(1);
      const count = counts[length];
      if (code - count < first) return symbols[index + code - first];
      index += count;
      first = (first + count) << 1;
      code <<= 1;
    }
    throw new Error("the cells' numbers are damaged");
  };
  const copyStored = () => {
    held = 0;
    bits = 0;
    const length = input[place] | (input[place + 1] << 8);
    output.set(input.subarray(place + 4, place + 4 + length), written);
    place += 4 + length;
    written += length;
  };
  const copyCoded = (literals, distances) => {
    for (;;) {
      const value = symbol(literals);
      if (value === 256) return;
      if (value < 256) {
        output[written++] = value;
        continue;
      }
      const length = LENGTH_BASE[value - 257] + take(LENGTH_EXTRA[value - 257]);
      const far = symbol(distances);
      const distance = DISTANCE_BASE[far] + take(DISTANCE_EXTRA[far]);
      for (const end = written + length; written < end; written++) output[written] = output[written - distance];
    }
  };
  const ownCodes = () => {
    const [literals, distances, count] = [take(5) + 257, take(5) + 1, take(4) + 4];
    const short = new Array(19).fill(0);
    for (let k = 0; k < count; k++) short[LENGTHS_ORDER[k]] = take(3);
    const code = huffman(short);
    const lengths = [];
    while (lengths.length < literals + distances) {
      const value = symbol(code);
      if (value < 16) lengths.push(value);
      else if (value === 16) repeat(lengths, lengths.at(-1), 3 + take(2));
      else repeat(lengths, 0, value === 17 ? 3 + take(3) : 11 + take(7));
    }
    return [huffman(lengths.slice(0, literals)), huffman(lengths.slice(literals))];
  };
  const fixedCodes = () => {
    const lengths = Array.from({ length: 288 }, (_, k) => (k < 144 ? 8 : k < 256 ? 9 : k < 280 ? 7 : 8));
    return [huffman(lengths), huffman(new Array(30).fill(5))];
  };
  let isLast = false;
  while (!isLast) {
    isLast = take(1) === 1;
    const kind = take(2);
    if (kind === 0) copyStored();
    else copyCoded(...(kind === 1 ? fixedCodes() : ownCodes()));
  }
  if (written !== size) throw new Error(`the cells' numbers are ${written} bytes instead of ${size}`);
  return output;
}

function repeat(list, value, count) {
  for (let k = 0; k < count; k++) list.push(value);
}
