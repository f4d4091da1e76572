// Entries of a log that are kept: the newest, as far as they are not too many, nor their texts too long together.

const SPARE = 1.2; // so many times what is kept may be there, as not to forget with each one

// The texts of an entry, and of its list of texts, count.
export class Kept {
  constructor(most, characters) {
    this.most = most;
    this.characters = characters;
    this.clear();
  }

  clear() {
    this.entries = [];
    this.size = 0; // characters
  }

  push(entry) {
    this.entries.push(entry);
    this.size += sizeOf(entry);
  }

  // Forget the oldest, if there are too many. Returns whether some were forgotten.
  forget() {
    if (this.entries.length <= this.most * SPARE && this.size <= this.characters * SPARE) return false;
    let count = 0;
    while (this.entries.length - count > this.most || this.size > this.characters) this.size -= sizeOf(this.entries[count++]);
    this.entries.splice(0, count);
    return true;
  }
}

function sizeOf(entry) {
  return entry.reduce((sum, part) => sum + (Array.isArray(part) ? sizeOf(part) : part.length || 0), 0);
}
