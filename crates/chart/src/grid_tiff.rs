//! GeoTIFF: grids as hydrographic agencies publish them.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use crate::grid_header::{Header, MISSING, check_square};
use crate::{Crs, Grid, GridDeclaration, Invalid};

/// Most bytes of an image, decoded.
const MOST_BYTES: usize = 1 << 30;
/// Keys of the GeoKey directory: how a value relates to its pixel, geographic and projected system.
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;
/// A value of `RASTER_TYPE`: it holds at the pixel's middle, which the coordinates are of.
const PIXEL_IS_POINT: u16 = 2;
/// A code of a system that has none.
const USER_DEFINED: u16 = 32767;

impl Grid {
    /// Reads a GeoTIFF of one band, its rows from north to south. Its EPSG code need not be declared.
    ///
    /// # Errors
    /// No TIFF of one band, or one that is damaged or too large; a grid that is turned, or not of squares; a system that is
    /// neither told nor declared, or told otherwise than declared; as [`Grid::from_ascii`].
    pub fn from_tiff(bytes: &[u8], declared: &GridDeclaration) -> Result<Self, Invalid> {
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MOST_BYTES;
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(refuse)?.with_limits(limits);
        let (columns, rows) = decoder.dimensions().map_err(refuse)?;
        let band = decoder.colortype().map_err(refuse)?;
        if !matches!(band, ColorType::Gray(_)) {
            let remedy = "write one band, for instance with `gdal_translate -b 1`";
            return Err(Invalid::new("GeoTIFF", format!("{band:?}"), "one band of numbers", remedy));
        }
        let keys = decoder.find_tag_unsigned_vec(Tag::GeoKeyDirectoryTag).map_err(refuse)?;
        let keys = Keys(keys.unwrap_or_default());
        let crs = keys.crs(declared.crs.as_ref())?;
        let [cell, west, north] = placed(&mut decoder, &keys)?;
        let no_data = decoder.find_tag(Tag::GdalNodata).map_err(refuse)?;
        let no_data = no_data.map(|text| text.into_string().map_err(refuse)).transpose()?;
        let no_data = no_data.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        let missing = |value: &f64| value.is_nan() || no_data == Some(*value);
        let image = decoder.read_image().map_err(refuse)?;
        let values = numbers(image)?.map(|value| if missing(&value) { MISSING } else { value }).collect();
        let header = Header {
            columns: columns as usize,
            rows: rows as usize,
            corner: [west, north - cell * f64::from(rows)],
            cell,
            no_data: MISSING,
        };
        Self::of(&header, values, crs, declared)
    }
}

/// Side of a cell, western and northern edge.
fn placed(decoder: &mut Decoder<Cursor<&[u8]>>, keys: &Keys) -> Result<[f64; 3], Invalid> {
    let scale = decoder.get_tag_f64_vec(Tag::ModelPixelScaleTag);
    let point = decoder.get_tag_f64_vec(Tag::ModelTiepointTag);
    let (Ok([width, height, ..]), Ok([column, row, _, x, y, _])) = (scale.as_deref(), point.as_deref())
    else {
        return Err(Invalid::new(
            "GeoTIFF",
            "no scale with one tie point",
            "a grid along the axes of its system",
            "straighten it, for instance with `gdalwarp`",
        ));
    };
    let cell = check_square(*width, *height)?;
    let half = if keys.value(RASTER_TYPE) == Some(PIXEL_IS_POINT) { 0.5 } else { 0.0 };
    Ok([cell, x - cell * (column + half), y + cell * (row + half)])
}

/// The GeoKey directory: a header, then key, place, count and value.
struct Keys(Vec<u16>);

impl Keys {
    /// The value of a key that stands in the directory itself.
    fn value(&self, key: u16) -> Option<u16> {
        let entries = self.0.get(4..)?.chunks_exact(4);
        entries.filter(|entry| entry[0] == key && entry[1] == 0).map(|entry| entry[3]).next()
    }

    /// The system that is told, or declared.
    fn crs(&self, declared: Option<&Crs>) -> Result<Crs, Invalid> {
        let codes = [PROJECTED, GEOGRAPHIC].map(|key| self.value(key));
        let told = codes.into_iter().flatten().find(|code| *code != 0 && *code != USER_DEFINED);
        match (told, declared) {
            (None, None) => Err(Crs::undeclared()),
            (None, Some(declared)) => Ok(declared.clone()),
            (Some(code), None) => Crs::new(&format!("EPSG:{code}")),
            (Some(code), Some(declared)) => {
                let code = format!("EPSG:{code}");
                let wgs84 = |name: &str| ["WGS84", "EPSG:4326"].contains(&name.to_ascii_uppercase().as_str());
                let name = declared.name();
                if name.eq_ignore_ascii_case(&code) || name.starts_with('+') || wgs84(&code) && wgs84(name) {
                    return Ok(declared.clone());
                }
                let expected = format!("{code}, as the file says");
                Err(Invalid::new("`crs`", name, expected, "leave `crs` out, or mend the file"))
            }
        }
    }
}

fn numbers(image: DecodingResult) -> Result<Box<dyn Iterator<Item = f64>>, Invalid> {
    Ok(match image {
        DecodingResult::U8(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::I8(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::U16(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::I16(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::U32(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::I32(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::F32(all) => Box::new(all.into_iter().map(f64::from)),
        DecodingResult::F64(all) => Box::new(all.into_iter()),
        _ => {
            let remedy = "write it as Float32, for instance with `gdal_translate -ot Float32`";
            let expected = "integers of 8 to 32 bits, or numbers of 32 or 64 bits";
            return Err(Invalid::new("GeoTIFF", "numbers of another width", expected, remedy));
        }
    })
}

fn refuse(error: TiffError) -> Invalid {
    Invalid::new(
        "GeoTIFF",
        error.to_string(),
        "a whole GeoTIFF, uncompressed or with LZW or deflate",
        "export it again, for instance with `gdal_translate -co COMPRESS=DEFLATE`",
    )
}
