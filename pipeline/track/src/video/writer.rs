//! Encoding of grey pictures to a film: H.264 in an MP4, the same bytes each time.
//!
//! One encoder thread and no creation time, so equal pictures make equal files.

use super::VideoError;
use crate::Gray;
use mp4::{AvcConfig, MediaConfig, Mp4Config, Mp4Sample, Mp4Writer, TrackConfig, TrackType};
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, Complexity, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, QpRange, RateControlMode,
    UsageType, VuiConfig,
};
use openh264::formats::YUVSlices;
use si::Hertz;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Start code in front of every NAL unit of a bare H.264 stream.
pub(super) const START_CODE: [u8; 4] = [0, 0, 0, 1];
/// Ticks of one frame in the container, so that the clock runs in thousandths of the frame rate.
const TICKS_A_FRAME: u32 = 1000;
/// A key frame every two seconds at 60 frames/s, as cameras do; damage then stays within that.
const KEY_FRAME_PERIOD: u32 = 120;
/// At a bit rate the encoder skips pictures while it exceeds the rate; it is called again up to this often, so that none is lost.
const SKIPS: usize = 240;
/// Neutral chroma.
const NO_COLOUR: u8 = 128;
/// NAL unit types of the parameter sets (H.264, table 7-1).
pub(super) const SEQUENCE_PARAMETERS: u8 = 7;
const PICTURE_PARAMETERS: u8 = 8;

/// How much is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// A goal for the mean size, bits a second.
    BitsPerSecond(u32),
    /// A fixed quantiser, 12 (finest) … 51; 18 looks like the original, 28 is poor. Where it is so fine that sensor noise is
    /// coded (22 for 2 grey levels of it), writing takes six times and reading eight times as long.
    Quantiser(u8),
}

/// A film that is being written.
pub struct Writer {
    path: PathBuf,
    width: usize,
    height: usize,
    rate: Hertz,
    encoder: Encoder,
    chroma: Vec<u8>,
    file: Option<Mp4Writer<BufWriter<File>>>,
    frames: usize,
}

impl Writer {
    /// Begins a film of `size` (width, height; px) with `rate` frames a second; an older file of that name is replaced.
    ///
    /// # Errors
    /// [`VideoError`] when the size is odd or too large for the codec, the rate or quality has no meaning, or the disk refuses.
    pub fn create(path: &Path, size: (usize, usize), rate: Hertz, quality: Quality) -> Result<Self, VideoError> {
        check_options(path, size, rate, quality)?;
        let (width, height) = size;
        let config = encoder_settings(rate, quality);
        let encoder =
            Encoder::with_api_config(OpenH264API::from_source(), config).map_err(|e| codec_error(path, 0, &e))?;
        let chroma = vec![NO_COLOUR; width * height / 4];
        Ok(Self { path: path.into(), width, height, rate, encoder, chroma, file: None, frames: 0 })
    }

    /// Adds one picture.
    ///
    /// # Errors
    /// [`VideoError`] when the picture has another size than the film, the codec fails, or the disk is full.
    pub fn push(&mut self, picture: &Gray) -> Result<(), VideoError> {
        if (picture.width, picture.height) != (self.width, self.height) {
            let why = format!(
                "picture {} has {} × {} px, the film {} × {}",
                self.frames, picture.width, picture.height, self.width, self.height
            );
            return Err(unfit_error(&self.path, why, "give all pictures of a film one size"));
        }
        if let Err(error) = picture.check() {
            return Err(unfit_error(&self.path, error.why(), error.action()));
        }
        let half = self.width / 2;
        let planes = (&picture.pixels[..], &self.chroma[..], &self.chroma[..]);
        let yuv = YUVSlices::new(planes, (self.width, self.height), (self.width, half, half));
        for _ in 0..SKIPS {
            let coded = self.encoder.encode(&yuv).map_err(|e| codec_error(&self.path, self.frames, &e))?;
            let is_sync = matches!(coded.frame_type(), FrameType::IDR | FrameType::I);
            let stream = coded.to_vec();
            if !stream.is_empty() {
                return self.store_picture(&stream, is_sync);
            }
        }
        Err(unfit_error(&self.path, format!("picture {} does not fit the bit rate", self.frames), "raise the bit rate"))
    }

    /// Ends the film: writes its index. Without this call the file cannot be read.
    ///
    /// # Errors
    /// [`VideoError`] when no picture was given or the disk is full.
    pub fn finish(mut self) -> Result<(), VideoError> {
        let Some(mut file) = self.file.take() else {
            return Err(unfit_error(&self.path, "it has no picture".into(), "push one before finishing"));
        };
        let failed = |e| container_error(&self.path, e);
        file.write_end().map_err(failed)?;
        let inner = file.into_writer().into_inner().map_err(|e| disk_error(&self.path, e.into_error()))?;
        inner.sync_all().map_err(|e| disk_error(&self.path, e))
    }

    fn store_picture(&mut self, stream: &[u8], is_sync: bool) -> Result<(), VideoError> {
        let (mut sample, mut sequence, mut picture) = (Vec::with_capacity(stream.len() + 16), None, None);
        for unit in openh264::nal_units(stream).map(|u| &u[start_code_length(u)..]) {
            match unit.first().map(|b| b & 0x1f) {
                Some(SEQUENCE_PARAMETERS) => sequence = Some(unit),
                Some(PICTURE_PARAMETERS) => picture = Some(unit),
                Some(_) => {
                    sample.extend_from_slice(&(unit.len() as u32).to_be_bytes());
                    sample.extend_from_slice(unit);
                }
                None => {}
            }
        }
        if self.file.is_none() {
            self.file = Some(self.begin_file(sequence.unwrap_or_default(), picture.unwrap_or_default())?);
        }
        let start_time = self.frames as u64 * u64::from(TICKS_A_FRAME);
        let sample =
            Mp4Sample { start_time, duration: TICKS_A_FRAME, rendering_offset: 0, is_sync, bytes: sample.into() };
        if let Some(file) = &mut self.file {
            file.write_sample(1, &sample).map_err(|e| container_error(&self.path, e))?;
        }
        self.frames += 1;
        Ok(())
    }

    fn begin_file(&self, sequence: &[u8], picture: &[u8]) -> Result<Mp4Writer<BufWriter<File>>, VideoError> {
        let timescale = (self.rate * f64::from(TICKS_A_FRAME)).round() as u32;
        let config = Mp4Config {
            major_brand: (*b"isom").into(),
            minor_version: 512,
            compatible_brands: [*b"isom", *b"iso2", *b"avc1", *b"mp41"].map(Into::into).into(),
            timescale,
        };
        let film = AvcConfig {
            width: self.width as u16,
            height: self.height as u16,
            seq_param_set: sequence.into(),
            pic_param_set: picture.into(),
        };
        let track = TrackConfig {
            track_type: TrackType::Video,
            timescale,
            language: "und".into(),
            media_conf: MediaConfig::AvcConfig(film),
        };
        let out = BufWriter::new(File::create(&self.path).map_err(|e| disk_error(&self.path, e))?);
        let mut file = Mp4Writer::write_start(out, &config).map_err(|e| container_error(&self.path, e))?;
        file.add_track(&track).map_err(|e| container_error(&self.path, e))?;
        Ok(file)
    }
}

/// Camera mode of the encoder in one thread, without options that take bits from still regions.
fn encoder_settings(rate: Hertz, quality: Quality) -> EncoderConfig {
    let config = EncoderConfig::new()
        .max_frame_rate(FrameRate::from_hz(rate as f32))
        .usage_type(UsageType::CameraVideoRealTime)
        .complexity(Complexity::Low)
        .intra_frame_period(IntraFramePeriod::from_num_frames(KEY_FRAME_PERIOD))
        .scene_change_detect(false)
        .adaptive_quantization(false)
        .background_detection(false)
        .num_threads(1)
        .vui(VuiConfig::bt709_full());
    match quality {
        Quality::BitsPerSecond(bits) => {
            config.rate_control_mode(RateControlMode::Bitrate).bitrate(BitRate::from_bps(bits))
        }
        // this mode keeps the quantiser inside its range whatever the size, and prints nothing on stderr
        Quality::Quantiser(step) => {
            config.rate_control_mode(RateControlMode::Bufferbased).bitrate(UNBOUND).qp(QpRange::new(step, step))
        }
    }
}

/// A bit rate for the header alone, where the quantiser is fixed.
const UNBOUND: BitRate = BitRate::from_bps(50_000_000);
/// The finest quantiser of the encoder.
const FINEST: u8 = 12;

fn check_options(
    path: &Path,
    (width, height): (usize, usize),
    rate: Hertz,
    quality: Quality,
) -> Result<(), VideoError> {
    let is_valid_side = |v: usize| v.is_multiple_of(2) && (16..=3840).contains(&v);
    if !is_valid_side(width) || !is_valid_side(height) {
        let why = format!("{width} × {height} px; H.264 takes even sizes of 16 … 3840 px");
        return Err(unfit_error(path, why, "choose an even size within that"));
    }
    if !(rate.is_finite() && (0.01..=1000.0).contains(&rate)) {
        return Err(unfit_error(path, format!("{rate} frames/s"), "choose a rate of 0.01 … 1000 frames/s"));
    }
    match quality {
        Quality::Quantiser(step) if !(FINEST..=51).contains(&step) => {
            Err(unfit_error(path, format!("a quantiser of {step}"), "choose one of 12 … 51"))
        }
        Quality::BitsPerSecond(bits) if !(1000..=2_000_000_000).contains(&bits) => {
            Err(unfit_error(path, format!("{bits} bits/s"), "choose 1e3 … 2e9 bits/s"))
        }
        _ => Ok(()),
    }
}

fn start_code_length(unit: &[u8]) -> usize {
    unit.iter().position(|&b| b == 1).map_or(0, |i| i + 1)
}

fn unfit_error(path: &Path, why: String, action: &'static str) -> VideoError {
    VideoError::Unfit { path: path.into(), why, action }
}

fn codec_error(path: &Path, frame: usize, error: &openh264::Error) -> VideoError {
    unfit_error(path, format!("the encoder refuses picture {frame}: {error}"), "check the size and rate of the film")
}

fn container_error(path: &Path, error: mp4::Error) -> VideoError {
    match error {
        mp4::Error::IoError(source) => disk_error(path, source),
        other => unfit_error(path, other.to_string(), "check the size and rate of the film"),
    }
}

fn disk_error(path: &Path, source: std::io::Error) -> VideoError {
    VideoError::Disk { path: path.into(), doing: "written", source }
}
