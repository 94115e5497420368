// What DPF asks of every plugin to define: names, ports, abilities.
#pragma once

#define DISTRHO_PLUGIN_BRAND "Earpoint"
#define DISTRHO_PLUGIN_NAME "Earpoint"
#define DISTRHO_PLUGIN_URI "urn:earpoint:plugin"
#define DISTRHO_PLUGIN_CLAP_ID "earpoint.plugin"
#define DISTRHO_PLUGIN_CLAP_FEATURES "audio-effect", "stereo", "mixing"
#define DISTRHO_PLUGIN_LV2_CATEGORY "lv2:SpatialPlugin"
#define DISTRHO_PLUGIN_VST3_CATEGORIES "Fx|Spatial|Stereo"

#define DISTRHO_PLUGIN_NUM_INPUTS 2
#define DISTRHO_PLUGIN_NUM_OUTPUTS 2
#define DISTRHO_PLUGIN_IS_RT_SAFE 1
#define DISTRHO_PLUGIN_WANT_LATENCY 1
#define DISTRHO_PLUGIN_HAS_UI 0

// CLAP hosts keep parameters in the plugin's own state, which DPF writes only for plugins with
// states. In LV2, whose hosts keep parameters themselves, that would need a worker.
#ifdef DISTRHO_PLUGIN_TARGET_CLAP
#define DISTRHO_PLUGIN_WANT_STATE 1
#endif
