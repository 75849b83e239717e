// The WebAssembly module of the playground: questions as JSON, answers as bytes.

/** @param {WebAssembly.Module} compiled
 *  @param {(bytes: ArrayBuffer) => void} published what is to be drawn, in turn */
export async function instance(compiled, published) {
  let memory;
  const copied = (address, length) => memory.buffer.slice(address >>> 0, (address >>> 0) + length);
  const host = { published: (...place) => published(copied(...place)) };
  const imports = { host };
  for (const { module, name } of WebAssembly.Module.imports(compiled)) {
    // Parts of libraries that ask a browser for random numbers, which nothing here needs.
    (imports[module] ??= {})[name] ??= () => { throw new ReferenceError(`${name} is not there`); };
  }
  const made = await WebAssembly.instantiate(compiled, imports);
  const { reserve, ask, answer, answer_length: length } = made.exports;
  memory = made.exports.memory;
  return (question) => {
    const bytes = new TextEncoder().encode(JSON.stringify(question));
    // (An unsigned number of 32 bits; memory may grow, which makes another buffer of it.)
    const address = reserve(bytes.length) >>> 0;
    new Uint8Array(memory.buffer, address, bytes.length).set(bytes);
    const isAnswer = ask() === 1;
    const said = copied(answer(), length() >>> 0);
    if (!isAnswer) throw new Error(new TextDecoder().decode(said));
    return said;
  };
}
