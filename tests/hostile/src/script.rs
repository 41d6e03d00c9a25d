//! Bytes as a source of decisions, for promises that are about what happens one after the other.

/// What is left of them; zeros when they have run out.
pub(crate) struct Script<'a> {
    bytes: &'a [u8],
}

impl<'a> Script<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Script<'a> {
        Script { bytes }
    }

    /// The next step; `None` at the end.
    pub(crate) fn step(&mut self) -> Option<u8> {
        let (&byte, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(byte)
    }

    pub(crate) fn byte(&mut self) -> u8 {
        self.step().unwrap_or(0)
    }

    pub(crate) fn u16(&mut self) -> u16 {
        u16::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    pub(crate) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    pub(crate) fn u64(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    /// What stands before the next such byte, which is taken too; all there is where there is none.
    pub(crate) fn until(&mut self, end: u8) -> &'a [u8] {
        let at = self.bytes.iter().position(|byte| *byte == end).unwrap_or(self.bytes.len());
        let found = self.bytes(at);
        self.step();
        found
    }

    /// At most so many bytes as they are.
    pub(crate) fn bytes(&mut self, most: usize) -> &'a [u8] {
        let (bytes, rest) = self.bytes.split_at(most.min(self.bytes.len()));
        self.bytes = rest;
        bytes
    }
}
