// The newest entries of a log, limited by their number and total length.

const SLACK = 1.2; // factor by which the limits may be exceeded before entries are dropped

// The length counts the strings in an entry, and in lists within it.
export class LogBuffer {
  constructor(maxEntries, maxCharacters) {
    this.maxEntries = maxEntries;
    this.maxCharacters = maxCharacters;
    this.entries = [];
    this.size = 0; // characters
  }

  clear() {
    this.entries = [];
    this.size = 0;
  }

  push(entry) {
    this.entries.push(entry);
    this.size += sizeOf(entry);
  }

  // Drop the oldest entries if there are too many. Returns whether any were dropped.
  trim() {
    if (this.entries.length <= this.maxEntries * SLACK && this.size <= this.maxCharacters * SLACK) return false;
    let count = 0;
    while (this.entries.length - count > this.maxEntries || this.size > this.maxCharacters) this.size -= sizeOf(this.entries[count++]);
    this.entries.splice(0, count);
    return true;
  }
}

function sizeOf(entry) {
  return entry.reduce((sum, part) => sum + (Array.isArray(part) ? sizeOf(part) : part.length || 0), 0);
}
