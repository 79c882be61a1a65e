//! The words of a `.c3d`, as one of three kinds of processor writes them.

/// The processor that wrote a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Processor {
    /// Little-endian, 84.
    Intel,
    /// Little-endian integers, and real numbers of its own, 85.
    Dec,
    /// Big-endian, 86.
    Mips,
}

/// The bytes of a file and who wrote them. What lies beyond the end reads as zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words<'a> {
    pub bytes: &'a [u8],
    pub processor: Processor,
}

impl<'a> Words<'a> {
    /// The fourth byte of the parameters, which begin at `parameters`, names the processor; unknown ones are taken for the most frequent.
    pub(super) fn new(bytes: &'a [u8], parameters: usize) -> Self {
        let processor = match bytes.get(parameters + 3) {
            Some(85) => Processor::Dec,
            Some(86) => Processor::Mips,
            _ => Processor::Intel,
        };
        Self { bytes, processor }
    }

    fn byte_array<const N: usize>(&self, offset: usize) -> [u8; N] {
        self.bytes.get(offset..).and_then(|tail| tail.first_chunk().copied()).unwrap_or([0; N])
    }

    pub(super) fn byte(&self, at: usize) -> u8 {
        self.byte_array::<1>(at)[0]
    }

    /// A count of two bytes.
    pub(super) fn count(&self, at: usize) -> u16 {
        match self.processor {
            Processor::Mips => u16::from_be_bytes(self.byte_array(at)),
            Processor::Intel | Processor::Dec => u16::from_le_bytes(self.byte_array(at)),
        }
    }

    /// An integer of two bytes.
    pub(super) fn integer(&self, at: usize) -> i16 {
        self.count(at).cast_signed()
    }

    /// A real number of four bytes.
    pub(super) fn real(&self, at: usize) -> f32 {
        let [a, b, c, d] = self.byte_array(at);
        match self.processor {
            Processor::Intel => f32::from_le_bytes([a, b, c, d]),
            Processor::Mips => f32::from_be_bytes([a, b, c, d]),
            // the two halves change places, and the exponent is greater by two
            Processor::Dec => f32::from_le_bytes([c, d, a, b]) / 4.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_each_processor_writes_them() {
        for (kind, integer, real) in [
            (84, [0xfe, 0xff], [0x00, 0x00, 0xc8, 0xc2]),
            (85, [0xfe, 0xff], [0xc8, 0xc3, 0x00, 0x00]),
            (86, [0xff, 0xfe], [0xc2, 0xc8, 0x00, 0x00]),
        ] {
            let bytes = [&[0, 0, 0, kind][..], &integer, &real].concat();
            let words = Words::new(&bytes, 0);
            assert_eq!((words.integer(4), words.count(4), words.real(6)), (-2, 65_534, -100.0), "{kind}");
            assert_eq!((words.integer(40), words.real(8)), (0, 0.0), "beyond the end");
        }
    }
}
