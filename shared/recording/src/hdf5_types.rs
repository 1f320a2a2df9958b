//! Which types of HDF5 are numbers, and where they stand in an element.

use crate::numbers::Number;
use hdf5_reader::{ByteOrder, Datatype};

/// A number of an element; an element that is one number is one field without a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    pub name: String,
    /// None of what is not read.
    pub number: Option<Number>,
    pub big_endian: bool,
    /// Of the first byte in the element.
    pub offset: usize,
    /// Numbers of the field in one element.
    pub shape: Vec<usize>,
}

/// The fields of a type.
///
/// # Errors
/// Why it is not read, in words.
pub(crate) fn fields(kind: &Datatype) -> Result<Vec<Field>, String> {
    if let Datatype::Compound { size, fields } = kind {
        let size = *size as usize;
        let fields: Vec<Field> = fields
            .iter()
            .map(|field| {
                let offset = field.byte_offset as usize;
                let read = single(&field.datatype).filter(|read| fits(read, offset, size));
                let unread = Field { name: String::new(), number: None, big_endian: false, offset, shape: Vec::new() };
                Field { name: field.name.clone(), offset, ..read.unwrap_or(unread) }
            })
            .collect();
        if is_complex(&fields) {
            return Err("complex numbers: save the real and the imaginary part".into());
        }
        return Ok(fields);
    }
    let field = single(kind).ok_or_else(|| reason(kind))?;
    Ok(vec![field])
}

/// Whether the numbers of a field lie in an element of so many bytes.
fn fits(field: &Field, offset: usize, size: usize) -> bool {
    let width = field.number.map_or(0, Number::width);
    let bytes = field.shape.iter().try_fold(width, |bytes, length| bytes.checked_mul(*length));
    bytes.and_then(|bytes| bytes.checked_add(offset)).is_some_and(|end| end <= size)
}

/// How h5py and MATLAB write complex numbers.
fn is_complex(fields: &[Field]) -> bool {
    let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
    matches!(names[..], ["r", "i"] | ["real", "imag"])
}

fn single(kind: &Datatype) -> Option<Field> {
    let (number, byte_order) = match kind {
        Datatype::FixedPoint { size, signed, byte_order } => (Number::whole(usize::from(*size), *signed)?, *byte_order),
        Datatype::FloatingPoint { size, byte_order } => (Number::float(usize::from(*size))?, *byte_order),
        Datatype::Bitfield { size, byte_order } => (Number::whole(usize::from(*size), false)?, *byte_order),
        // h5py writes truths as an enumeration.
        Datatype::Enum { base, .. } => return single(base).filter(|field| field.shape.is_empty()),
        Datatype::Array { base, dims } => {
            let field = single(base).filter(|field| field.shape.is_empty())?;
            let shape: Option<Vec<usize>> = dims.iter().map(|length| usize::try_from(*length).ok()).collect();
            return Some(Field { shape: shape?, ..field }).filter(|field| fits(field, 0, usize::from(u16::MAX)));
        }
        _ => return None,
    };
    let big_endian = byte_order == ByteOrder::BigEndian;
    Some(Field { name: String::new(), number: Some(number), big_endian, offset: 0, shape: Vec::new() })
}

fn reason(kind: &Datatype) -> String {
    match kind {
        Datatype::String { .. } | Datatype::VarLen { .. } => "text or lists".into(),
        Datatype::Reference { .. } => "references".into(),
        _ => "a type that is no number".into(),
    }
}

/// Whether an array of this class of MATLAB has numbers.
pub(crate) fn is_numeric(class: &str) -> bool {
    matches!(
        class,
        "double"
            | "single"
            | "logical"
            | "int8"
            | "uint8"
            | "int16"
            | "uint16"
            | "int32"
            | "uint32"
            | "int64"
            | "uint64"
    )
}

/// Why a variable of this class of MATLAB is not read.
pub(crate) fn matlab_reason(class: &str) -> String {
    match class {
        "char" => "text".into(),
        "cell" => "a cell array: save it with `save(..., '-v7')`".into(),
        _ if is_numeric(class) => "a sparse matrix: save `full(x)`".into(),
        other => crate::matlab_values::object_reason(other),
    }
}
