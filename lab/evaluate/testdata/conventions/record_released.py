#!/usr/bin/env python3
"""Records what released evaluations say of the sounds beside this script.

Usage: record_released.py --avnerf DIR --naf DIR --neraf DIR --avr DIR --auraloss DIR --pyroomacoustics DIR

Each DIR is a checkout of the repository that `REPOSITORIES` names; pyroomacoustics at its tag v0.7.3, the version
that the evaluations of its time used. Their functions are imported and run; nothing of them is copied here. Calls
of libraries that are not in Debian are answered by what their documentation says, computed with NumPy, SciPy and
PyTorch: librosa.stft, librosa.util.fix_length, torchaudio.functional.highpass_biquad,
torchaudio.transforms.Spectrogram. The options of a released script, and h5py, from which it reads nothing here, are
replaced as well. ISO 3382-1 has no released code: its band values are computed here with SciPy.
Writes released.json. Needs python3-numpy, python3-scipy and python3-torch.
"""
import argparse
import importlib
import json
import pathlib
import pickle
import runpy
import subprocess
import sys
import tempfile
import types
import unittest.mock

import numpy as np
import scipy
import scipy.ndimage
import scipy.signal
import torch
from scipy.io import wavfile

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORIES = {
    "avnerf": "liangsusan-git/AV-NeRF",
    "naf": "aluo-x/Learning_Neural_Acoustic_Fields",
    "neraf": "AmandineBtto/NeRAF",
    "avr": "penn-waves-lab/AVR",
    "auraloss": "csteinmetz1/auraloss",
    "pyroomacoustics": "LCAV/pyroomacoustics",
}


def read(name):
    """A sound as float32 [channels, samples], and its rate."""
    rate, samples = wavfile.read(HERE / name)
    return rate, np.atleast_2d((samples.astype(np.float32) / np.float32(32768.0)).T)


def stand_in(name, **members):
    """A module that imports find in place of the real one."""
    module = types.ModuleType(name)
    for key, value in members.items():
        setattr(module, key, value)
    sys.modules[name] = module
    return module


def librosa_stft(pad_mode):
    """librosa.stft: a periodic Hann window of n_fft, hop n_fft / 4, centred frames, complex64.

    @param pad_mode  "constant" since 0.10, "reflect" before
    """
    def stft(y, n_fft=2048, hop_length=None):
        hop = hop_length or n_fft // 4
        padded = np.pad(y, n_fft // 2, mode=pad_mode)
        window = scipy.signal.get_window("hann", n_fft)
        frames = np.lib.stride_tricks.sliding_window_view(padded, n_fft)[::hop]
        return np.fft.rfft(frames * window).T.astype(np.complex64)
    return stft


def fix_length(data, size):
    return np.pad(data, [(0, 0)] * (data.ndim - 1) + [(0, max(0, size - data.shape[-1]))])[..., :size]


def highpass_biquad(waveform, sample_rate, cutoff_freq, Q=0.707):
    """SoX's high-pass biquad, clamped to [-1, 1] (lfilter's default)."""
    w = 2 * np.pi * cutoff_freq / sample_rate
    alpha, cosine = np.sin(w) / 2 / Q, np.cos(w)
    b = [(1 + cosine) / 2, -1 - cosine, (1 + cosine) / 2]
    out = scipy.signal.lfilter(b, [1 + alpha, -2 * cosine, 1 - alpha], waveform.numpy().astype(np.float64))
    return torch.from_numpy(np.clip(out, -1, 1).astype(np.float32))


class Spectrogram:
    """torchaudio.transforms.Spectrogram: torch.stft with a periodic Hann window and reflection."""

    def __init__(self, n_fft, win_length, hop_length, power):
        assert power is None
        self.shape = (n_fft, hop_length, win_length, torch.hann_window(win_length))

    def __call__(self, waveform):
        n_fft, hop, length, window = self.shape
        return torch.stft(waveform, n_fft, hop, length, window, return_complex=True)


def install_stand_ins(folders):
    stand_in("librosa", stft=librosa_stft("constant"), util=types.SimpleNamespace(fix_length=fix_length),
             resample=lambda y, orig_sr, target_sr: y)
    functional = stand_in("torchaudio.functional", highpass_biquad=highpass_biquad)
    transforms = stand_in("torchaudio.transforms", Spectrogram=Spectrogram)
    stand_in("torchaudio", functional=functional, transforms=transforms)
    rt60 = runpy.run_path(str(folders["pyroomacoustics"] / "pyroomacoustics/experimental/rt60.py"))
    stand_in("pyroomacoustics", experimental=types.SimpleNamespace(measure_rt60=rt60["measure_rt60"]))


def fresh_import(folder, name):
    """Imports a module of a checkout, without those of other checkouts that have the same name."""
    for known in [m for m in sys.modules if m.split(".")[0] in ("utils", "testing", "options")]:
        del sys.modules[known]
    with unittest.mock.patch.object(sys, "path", [str(folder), *sys.path]):
        return importlib.import_module(name)


def rwavs(folder):
    evaluator = fresh_import(folder, "utils").Evaluator()
    _, reference = read("speech_reference.wav")
    _, estimate = read("speech_estimate.wav")
    return {"function": "utils.Evaluator.Magnitude_distance, Envelope_distance",
            "mag": evaluator.Magnitude_distance(estimate, reference),
            "env": evaluator.Envelope_distance(estimate, reference)}


def cut_off_sound(samples):
    """25 samples of +-0.5 at the end, which fall by 11 dB: no T60, all of it late."""
    sound = np.zeros((1, samples), np.float32)
    sound[:, -25:] = 0.5 * (-1.0) ** np.arange(25)
    return sound


def raf_of(module, rate, reference, estimate):
    evaluator = module.RAFEvaluator(fs=rate)
    frames = reference.shape[1] // evaluator.hop_len
    log_gt = torch.log(torch.abs(evaluator.transform_stft_torch(torch.tensor(reference))) + 1e-3)[..., :frames]
    found = evaluator.get_full_metrics(None, None, reference, estimate, reference, None, log_gt.numpy())
    return {"stft_error": found["audio_stft_error"], "t60_error_percent": found["audio_T60"],
            "t60_invalid": bool(found["audio_total_invalids_T60"]), "edt_error_s": found["audio_EDT"],
            "c50_error_db": found["audio_C50"]}


def raf(folder):
    module = fresh_import(folder, "NeRAF.NeRAF_evaluator")
    rate, reference = read("rir_reference.wav")
    _, estimate = read("rir_estimate.wav")
    cut = int(0.32 * rate)
    late = cut_off_sound(cut)
    return {"function": "NeRAF.NeRAF_evaluator.RAFEvaluator.get_full_metrics",
            "at_48_khz": raf_of(module, rate, reference[:, :cut], estimate[:, :cut]),
            "at_16_khz": raf_of(module, 16000, reference[:, :cut:3].copy(), estimate[:, :cut:3].copy()),
            "cut_off": raf_of(module, rate, reference[:, :cut], late)}


def naf_t60(folder, reference, estimate):
    """The released script on a data set of one pair."""
    with tempfile.TemporaryDirectory() as name:
        data = pathlib.Path(name)
        (data / "wav/room/0").mkdir(parents=True)
        wavfile.write(data / "wav/room/0/1_2.wav", 22050, reference.T)
        with open(data / "room_aac_linear.pkl", "wb") as file:
            pickle.dump({"0_1_2": estimate.T}, file)
        options = types.SimpleNamespace(exp_name="{}", apt="room", baseline_mode="aac", interp_mode="linear",
                                        save_loc=str(data), inference_loc=".", spec_base=str(data),
                                        wav_base=str(data / "wav"))
        stand_in("options", Options=lambda: types.SimpleNamespace(parse=lambda: options))
        stand_in("h5py", File=lambda path, mode: {})
        printed = []
        with unittest.mock.patch.object(sys, "path", [str(folder), *sys.path]), \
                unittest.mock.patch("builtins.print", lambda *words: printed.append(words)):
            runpy.run_path(str(folder / "testing/compute_T60_err_baseline.py"))
        del sys.modules["options"]
    return {"t60_error_percent": float(printed[-1][-1]), "t60_invalid": printed[-1][0].startswith("1 ")}


def naf(folder):
    sys.modules["librosa"].stft = librosa_stft("reflect")  # fix_length by position: before 0.10
    module = fresh_import(folder, "testing.test_utils")
    _, reference = read("brir_reference.wav")
    _, estimate = read("brir_estimate.wav")
    spectrum = module.get_spec().transform
    late = np.repeat(cut_off_sound(reference.shape[1]), 2, axis=0)
    return {"function": "testing.test_utils.get_spec.transform, spectral; testing/compute_T60_err_baseline.py",
            "spectral_loss": float(module.spectral(spectrum(estimate), spectrum(reference))),
            **naf_t60(folder, reference, estimate),
            "cut_off": naf_t60(folder, reference, late)}


def avr_of(module, rate, reference, estimate):
    names = ("phase", "amp", "env", "t60_error_ratio", "edt_error_s", "c50_error_db", "multi_stft")
    return dict(zip(names, map(float, module.metric_cal(reference, estimate, fs=rate)[:7])))


def avr(folder, auraloss):
    sys.path.append(str(auraloss))
    module = fresh_import(folder, "utils.metric")
    rate, reference = read("rir_reference.wav")
    _, estimate = read("rir_estimate.wav")
    # As its loader brings RAF to 16 kHz: every third sample, a tenth of a second.
    three = slice(0, 4800, 3)
    rate_b, binaural = read("brir_reference.wav")
    _, other = read("brir_estimate.wav")
    return {"function": "utils.metric.metric_cal",
            "at_16_khz": avr_of(module, rate // 3, reference[:, three].copy(), estimate[:, three].copy()),
            "two_channels": avr_of(module, rate_b, binaural, other)}


def iso_band(response, rate, centre):
    """Energies of a band: the response backwards through a Butterworth band-pass, parts cut before."""
    sections = scipy.signal.butter(3, [centre / np.sqrt(2), centre * np.sqrt(2)], "bandpass", fs=rate, output="sos")
    pad = int(0.25 * rate)

    def band(part):
        return scipy.signal.sosfilt(sections, np.concatenate([np.zeros(pad), part])[::-1])[::-1]

    def middle(signal):
        return np.sum((np.arange(signal.size) - pad) * signal**2) / np.sum(signal**2)

    direct = int(np.argmax(np.abs(response) >= np.float32(0.1) * np.abs(response).max()))
    values = {"centre_hz": centre}
    for name, limit in (("c50_db", 0.05), ("c80_db", 0.08)):
        split = direct + int(np.floor(limit * rate + 0.5))
        early = np.sum(band(response[direct:split]) ** 2)
        late = np.sum(band(response[split:]) ** 2)
        values[name] = 10 * np.log10(early / late)
        if name == "c50_db":
            values["d50"] = early / (early + late)
    values["ts_ms"] = 1000 * (middle(band(response)) - direct - middle(band(np.ones(1)))) / rate
    return values


def iso():
    rate, reference = read("rir_reference.wav")
    return {"function": "this script, with scipy.signal",
            "bands": [iso_band(reference[0].astype(np.float64), rate, c) for c in (125, 250, 500, 1000, 2000, 4000)]}


def finite(value):
    """The record without numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def commit_of(folder):
    return subprocess.run(["git", "-C", str(folder), "rev-parse", "HEAD"], check=True, capture_output=True,
                          text=True).stdout.strip()


def main():
    parser = argparse.ArgumentParser()
    for name in REPOSITORIES:
        parser.add_argument("--" + name, type=pathlib.Path, required=True)
    folders = {name: path.resolve() for name, path in vars(parser.parse_args()).items()}
    install_stand_ins(folders)
    record = {
        "repositories": {name: {"repository": "https://github.com/" + REPOSITORIES[name], "commit": commit_of(path)}
                         for name, path in folders.items()},
        "versions": {"numpy": np.__version__, "scipy": scipy.__version__, "torch": torch.__version__},
        "rwavs": rwavs(folders["avnerf"]),
        "raf": raf(folders["neraf"]),
        "naf": naf(folders["naf"]),
        "avr": avr(folders["avr"], folders["auraloss"]),
        "iso": iso(),
    }
    (HERE / "released.json").write_text(json.dumps(finite(record), indent=1, allow_nan=False) + "\n")


main()
