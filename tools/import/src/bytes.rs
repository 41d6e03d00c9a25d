//! Numbers out of binary files, never beyond their end.

/// What is left of a binary file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bytes<'b> {
    pub rest: &'b [u8],
    pub big: bool,
}

impl<'b> Bytes<'b> {
    pub(crate) fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes: [u8; N] = self.take(N)?.try_into().ok()?;
        if self.big {
            bytes.reverse();
        }
        Some(bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// One number of this type.
    pub(crate) fn number(&mut self, kind: Kind) -> Option<f64> {
        Some(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes(self.array()?)),
            Kind::U8 => f64::from(u8::from_le_bytes(self.array()?)),
            Kind::I16 => f64::from(i16::from_le_bytes(self.array()?)),
            Kind::U16 => f64::from(u16::from_le_bytes(self.array()?)),
            Kind::I32 => f64::from(i32::from_le_bytes(self.array()?)),
            Kind::U32 => f64::from(u32::from_le_bytes(self.array()?)),
            Kind::I64 => i64::from_le_bytes(self.array()?) as f64,
            Kind::U64 => u64::from_le_bytes(self.array()?) as f64,
            Kind::F32 => f64::from(f32::from_le_bytes(self.array()?)),
            Kind::F64 => f64::from_le_bytes(self.array()?),
        })
    }
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    pub(crate) fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }
}
