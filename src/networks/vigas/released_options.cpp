#include "released_options.h"

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

// What the released code's command for SoundSpaces-NVAS stores with a checkpoint: names, order and
// values of its options. Found by running it.
constexpr const char* kSoundSpaces = R"({
 "run_type": "train", "model_dir": "data/models", "dataset_dir": "data/synthetic_dataset/v16",
 "metadata_file": "cleaned_metadata_v3.json", "cam_position_file": "camera_positions.json",
 "version": "soundspaces_nvas", "eval_best": false, "eval_last": false, "auto_resume": true,
 "overwrite": false, "use_rgb": true, "use_depth": false, "num_channel": 2, "n_gpus": 1,
 "num_node": 16, "batch_size": 24, "max_epochs": 1000, "ckpt_interval": 10, "lr": 0.001, "wd": 0,
 "scheduler": "none", "dataset": "soundspaces_nvas", "log_mag": false, "no_mask": false,
 "log1p": false, "log10": false, "save_ckpt_interval": 1, "from_pretrained": "", "slurm": true,
 "gpu_mem32": true, "part": "", "test": false, "test_all": false,
 "test_split": "test", "visualize": false, "dropout": 0.2, "loss": "l1", "fast_dev_run": false,
 "progress_bar": false, "eval_ckpt": -1, "model": "vigas", "decode_wav": true,
 "encode_wav": false, "hop_length": 160, "sample_rate": 16000, "multires_stft": false,
 "multires_stft_no_sc": false, "mag_logmag": false, "spectral_stft": false,
 "remove_mel_loss": false, "fft_sizes": "256,512,1024", "hop_sizes": "64,128,256",
 "win_lengths": "128,400,600", "stft_loss_weight": 45, "encoder_ratios": "8,4,2,2",
 "decoder_ratios": "8,4,2,2", "encoder_residual_layers": 3, "decoder_residual_layers": 3,
 "ngf": 32, "predict_mask": false, "use_real_imag": false, "num_worker": 4, "eval_input": false,
 "comment": "", "prev_ckpt": -1, "use_tgt_rgb": false, "use_depth_mini": false,
 "use_tgt_depth": false, "use_tgt_pose": true, "use_input_phase": false, "mag": true,
 "rel_mag": false, "mag_rel_mag": false, "one_speaker": true, "use_speaker_pose": false,
 "use_speaker_pose_wrt_tgt": false, "use_intermediate_loss": false, "remove_delay": true,
 "remove_hyperconv": true, "audio_len": 16000, "kernel_size": 400, "wavenet_blocks": 3,
 "layers_per_block": 10, "subtract_mean": false, "use_same_speech": false,
 "use_spatial_classification_loss": false, "spatial_classification_loss_weight": 1,
 "use_viewpoint_contrastive_loss": false, "viewpoint_triplet_margin": 1,
 "viewpoint_contrastive_loss_weight": 1, "scale_mag": false, "use_scale_loss": false,
 "use_peak_scale": false, "use_rms_scale": false, "scale_loss_weight": 1, "input_mono": false,
 "output_mono": false, "randomize_speech_amplitude": false, "normalize_input": false,
 "fix_tgt_pose": false, "gradient_clip_val": 0, "plot_hist": false, "print_percent": false,
 "acausal": true, "use_speaker_bboxes": true, "use_tgt_rotation": true, "use_warper": false,
 "encode_sincos": true, "wave_l2_loss": false, "extra_wave_loss": false,
 "extra_wave_loss_weight": 1, "mlp_fusion": false, "scale_loss_only": false,
 "remove_wavenet": false, "skip_spec_loss": false, "use_clean_speech": false,
 "use_clean_as_tgt": false, "use_tgt_bboxes": false, "use_tgt_bboxes_as_mask": false,
 "use_tgt_rgb_pano": false, "no_stacking": false, "use_last_output": false,
 "wavenet_encoder": "hyperconv", "use_src_location": false, "use_tgt_location": false,
 "use_speaker_location": false, "no_prev_reverb": false, "highpass_filter": true,
 "single_channel": false, "dereverb_input": false,
 "dereverb_model": "",
 "index_binaural": false, "visualize_bboxes": false, "use_cam_index": false,
 "normalize_src": false, "normalize_tgt": false, "gcc_max_pool": false, "remove_tgt_index": false,
 "nn_tgt_weight": 1, "base_gain": 1, "use_avg_location": false, "rotate_rel_pose": false,
 "denoise": false, "use_all_bboxes": false, "use_local_conditioning": false,
 "eval_difficult": false
})";

// Where its command for Replay-NVAS differs.
constexpr const char* kReplay = R"({
 "dataset_dir": "data/appen_dataset/v3", "metadata_file": "metadata_v2.json",
 "cam_position_file": "camera_positions_fixed_rotation.json", "version": "replay_nvas",
 "n_gpus": 8, "num_node": 2, "max_epochs": 600, "dataset": "replay_nvas",
 "rotate_rel_pose": true
})";

}  // namespace

nlohmann::ordered_json released_options(PoseEncoding encoding) {
  auto options = nlohmann::ordered_json::parse(kSoundSpaces);
  if (encoding == PoseEncoding::replay) {
    options.update(nlohmann::ordered_json::parse(kReplay));
  }
  return options;
}

}  // namespace earpoint
