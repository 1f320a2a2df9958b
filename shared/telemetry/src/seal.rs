//! Samples that carry a checksum of what they say, beside the one of their transport: they are kept
//! in checkpoints and folded, or carried out, long after they were received.

/// `sealed` and `is_intact` of a sample that says something from the field `$first` on and ends it
/// with `crc32`: CRC-32 (IEEE) over all between. In which frame it is sent is not part of it.
macro_rules! sealed {
    ($name:ident, $first:ident) => {
        impl $name {
            fn sealed_bytes(&self) -> &[u8] {
                let bytes = zerocopy::IntoBytes::as_bytes(self);
                &bytes[core::mem::offset_of!($name, $first)..core::mem::offset_of!($name, crc32)]
            }

            #[doc = concat!("The same sample with `crc32` computed over all from `", stringify!($first), "` on.")]
            #[must_use]
            pub fn sealed(mut self) -> Self {
                self.crc32 = crate::crc32(self.sealed_bytes());
                self
            }

            #[doc = concat!("Whether `crc32` is that of all from `", stringify!($first), "` on: false after a change")]
            #[doc = concat!("there behind [`", stringify!($name), "::sealed`].")]
            #[must_use]
            pub fn is_intact(&self) -> bool {
                self.crc32 == crate::crc32(self.sealed_bytes())
            }
        }
    };
}
pub(crate) use sealed;
