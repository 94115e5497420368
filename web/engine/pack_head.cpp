// Writes the head-related impulse responses of a SOFA file as a head file for the engine.
//
// usage: engine_pack_head OUT.safetensors [HEAD.sofa]      by default the set that `--model dsp`
// uses
#include <cstdio>
#include <exception>

#include <earpoint/render/head_file.h>
#include <earpoint/spatial/sofa_file.h>
#include <earpoint/weights/safetensors.h>

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::fputs("usage: engine_pack_head OUT.safetensors [HEAD.sofa]\n", stderr);
    return 2;
  }
  try {
    const earpoint::SofaFile head =
        earpoint::read_sofa(argc == 3 ? argv[2] : earpoint::default_hrtf_path());
    earpoint::write_safetensors(argv[1], earpoint::to_head_file(head));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "engine_pack_head: %s\n", error.what());
    return 1;
  }
}
