# The command ./dev results. ./dev sources this file; say, fail, build, bench, demo, ensure_packages, install_assets,
# gather_speech and speech_folder are from there.
# shellcheck shell=bash disable=SC2154

# A network that ./dev assets --people installs.
installed_detector=${EARPOINT_DATA_DIR:-${XDG_DATA_HOME:-$HOME/.local/share}/earpoint}/people-nanodet.onnx

# The data of the paper's two set-ups, one home and unseen homes: half an hour on two cores, once.
simulate_data() {
  local earpoint=$1
  [ -f "$speech_folder/speech.csv" ] || gather_speech "$speech_folder"
  # Homes with stand-ins for furniture have other sound, and other test pairs.
  [ -f "$(dirname "$speech_folder")/models.pack" ] || install_assets
  say "Simulating one home and unseen homes into out/data"
  "$earpoint" simulate --scenes 120 --conversations 6 --rays 1000 --seed 11 --out out/data/novel
  "$earpoint" simulate --split train --scenes 16 --conversations 6 --viewpoints 5 --rays 1000 --seed 12 \
    --other-rooms 0.4 --out out/data/rooms
  "$earpoint" simulate --split train --scenes 24 --conversations 6 --viewpoints 5 --rays 1000 --seed 13 --reach 5 \
    --out out/data/far
  "$earpoint" simulate --split test --scenes 12 --conversations 3 --viewpoints 5 --rays 1000 --seed 99 --reach 5 \
    --other-rooms 0.3 --out out/data/places
  "$earpoint" simulate --scenes 1 --conversations 420 --rays 1000 --seed 3 --out out/data/single
}

# Trains on one thread, as sums depend on the number of threads; continues an interrupted run.
# Usage: train_run EARPOINT CONFIG DATA[,DATA...] RUN [KEY=VALUE...]
train_run() {
  local earpoint=$1 config=configs/$2.json data=$3 run=$4 setting folder settings=() folders=()
  shift 4
  for setting in "$@"; do settings+=(--set "$setting"); done
  for folder in ${data//,/ }; do folders+=(--data "$folder"); done
  say "Training $config ${settings[*]} on $data into $run"
  OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
    "$earpoint" train "$config" "${settings[@]}" "${folders[@]}" --out "$run" --jobs 1 --resume
}

# Networks without one of their parts, which are trained for fewer steps: NAME CONFIG [KEY=VALUE...]. Three seeds of the
# whole gtf show how much a training differs from the next.
ablations=(
  "gtf gtf"
  "gtf-seed-2 gtf training.seed=2"
  "gtf-seed-3 gtf training.seed=3"
  "gtf-blind gtf network.picture_px=0 network.box=false"
  "gtf-no-picture gtf network.picture_px=0"
  "gtf-no-3d gtf network.geometry=false network.expected_level=false network.delays=false network.ear_delays=false"
  "gtf-no-delay gtf network.delays=false network.ear_delays=false"
  "gtf-no-tail gtf network.tails_s=[]"
  "vigas vigas-small"
  "vigas-blind vigas-small network.picture=null network.box=false"
  "vigas-no-picture vigas-small network.picture=null"
  "vigas-no-box vigas-small network.box=false"
  "vigas-no-alignment vigas-small data.align=none"
)
# Smaller ones, as there are few recorded clips.
recorded_ablations=(
  "vigas vigas-small-replay"
  "vigas-blind vigas-small-replay network.picture=null network.box=false"
  "vigas-no-picture vigas-small-replay network.picture=null"
  "vigas-no-box vigas-small-replay network.box=false"
  "vigas-no-alignment vigas-small-replay data.align=none"
)

# Pairs that gtf learns from.
of_near_pairs="data.farthest_move_m=6 data.most_gain_db=12"

# Trains one of the ablations. Usage: train_ablation EARPOINT DATA RUN CONFIG [KEY=VALUE...]
train_ablation() {
  local earpoint=$1 data=$2 run=$3 config=$4 short=training.steps=1000
  shift 4
  [ "$config" != vigas-small ] || short="training.steps=1000 network.place_steps=600"
  # shellcheck disable=SC2086
  train_run "$earpoint" "$config" "$data" "$run" $short "$@"
}

# gtf: first the speaker's position alone, which costs little, and at the end with an estimator's reverberation times in its
# loss. That is another estimator than the one that RTE is measured with. Usage: train_gtf EARPOINT
train_gtf() {
  local earpoint=$1 data=out/data/novel runs=out/runs/novel estimator=out/estimator/novel
  train_run "$earpoint" rt60 "$data" "$estimator" training.seed=2 training.steps=2500
  # Homes in general, and fewer pairs with listeners in other rooms and farther away.
  data=$data,$data,$data,out/data/rooms,out/data/far
  # shellcheck disable=SC2086
  {
    train_run "$earpoint" gtf "$data" "$runs/gtf-located" network.place_steps=10000 training.steps=10000 \
      training.batch=32 network.loss.place=1 data.hidden_boxes=0.3 $of_near_pairs
    train_run "$earpoint" gtf "$data" "$runs/gtf-begun" training.steps=12000 network.loss.place=0.3 \
      "network.init=$runs/gtf-located/best.safetensors" $of_near_pairs
    train_run "$earpoint" gtf "$data" "$runs/gtf" training.seed=2 training.steps=2500 training.learning_rate=0.001 \
      "network.init=$runs/gtf-begun/best.safetensors" "network.estimator=$estimator/best.safetensors" \
      network.loss.natural.reverberation=1 network.loss.place=0.3 $of_near_pairs
  }
}

# What the tables of unseen homes compare.
train_unseen_homes() {
  local earpoint=$1 data=out/data/novel runs=out/runs/novel
  train_gtf "$earpoint"
  train_run "$earpoint" vigas-small "$data" "$runs/vigas" training.validate_every=600
  train_run "$earpoint" vigas-small "$data" "$runs/vigas-blind" network.picture=null network.box=false \
    training.validate_every=600
  train_run "$earpoint" vam "$data" "$runs/vam"
  train_ablations "$earpoint" novel
}

# What the tables of one home compare: shipped networks, trained on with the clips of that home (gtf as models/gtf.md says,
# part 4), and networks that have heard nothing else.
train_one_home() {
  local earpoint=$1 data=out/data/single runs=out/runs/single located=out/located/single
  # shellcheck disable=SC2086
  {
    train_run "$earpoint" gtf "$data" "$located" network.init=models/gtf.safetensors network.place_steps=4000 \
      training.steps=4000 training.batch=32 network.loss.place=1 data.hidden_boxes=0.3 $of_near_pairs
    train_run "$earpoint" gtf "$data" "$runs/gtf-adapted" "network.init=$located/best.safetensors" training.steps=2000 \
      training.batch=32 training.learning_rate=0.0015 network.loss.place=0.3 network.loss.phase_difference=0.06 \
      network.loss.natural.phase_difference=0.15 $of_near_pairs
  }
  train_run "$earpoint" vigas-small "$data" "$runs/vigas-adapted" network.init=models/vigas.safetensors \
    network.place_steps=400 training.steps=1600 training.validate_every=400
  train_run "$earpoint" vam "$data" "$runs/vam"
  train_ablations "$earpoint" single
}

# Usage: train_ablations EARPOINT DATA
train_ablations() {
  local earpoint=$1 data=out/data/$2 ablation name config settings
  for ablation in "${ablations[@]}"; do
    read -r name config settings <<<"$ablation"
    # shellcheck disable=SC2086
    train_ablation "$earpoint" "$data" "out/ablations/$2/$name" "$config" $settings
  done
  train_ablation "$earpoint" "$data" "out/ambient/$2/with-ambient" vigas-small \
    data.ambient_db=-40 data.separate=true
  train_ablation "$earpoint" "$data" "out/ambient/$2/no-separation" vigas-small \
    data.ambient_db=-40 data.separate=false
}

# Both data sets side by side, then enhancement: hours on two cores.
train_methods() {
  local earpoint=$1 novel single
  train_unseen_homes "$earpoint" &
  novel=$!
  train_one_home "$earpoint" &
  single=$!
  wait "$novel"
  wait "$single"
  train_run "$earpoint" enhance out/data/novel out/enhance/gtf network.init=out/runs/novel/gtf/best.safetensors
  train_run "$earpoint" vigas-small out/data/novel out/enhance/vigas network.init=out/runs/novel/vigas/best.safetensors \
    network.place_steps=0 training.steps=4000 data.target=near_microphone data.ambient_db=-40 data.faint_speech=0.2
}

# Networks that are trained on the clips of recorded sessions: few clips, so few steps.
train_recorded() {
  local earpoint=$1 data=out/data/recorded runs=out/runs/recorded ablation name config settings
  local near="data.target=near_microphone data.align=responses"
  # What starts from the shipped weights learns at lower rates.
  local from_vigas="network.init=models/vigas.safetensors training.learning_rate=0.0003 training.warmup_steps=30"
  local from_gtf="training.learning_rate=0.0005 training.validate_every=250"
  # shellcheck disable=SC2086
  {
    train_run "$earpoint" vigas-small-replay "$data" "$runs/vigas-adapted" training.steps=800 $from_vigas \
      training.validate_every=200
    train_run "$earpoint" gtf-replay "$data" "$runs/gtf-adapted" training.steps=1000 $from_gtf \
      network.init=models/gtf.safetensors
    train_run "$earpoint" gtf-replay "$data" "$runs/gtf-detected" training.steps=1000 $from_gtf \
      network.init=models/gtf.safetensors data.boxes=detected
    train_run "$earpoint" vam-replay "$data" "$runs/vam" training.steps=400 training.validate_every=100
    train_run "$earpoint" vigas-small-replay "$data" out/enhance-recorded/vigas training.steps=300 $from_vigas $near \
      training.validate_every=100
    train_run "$earpoint" enhance-replay "$data" out/enhance-recorded/gtf training.steps=500 $from_gtf \
      network.init=models/enhance.safetensors
  }
  for ablation in "${recorded_ablations[@]}"; do
    read -r name config settings <<<"$ablation"
    # shellcheck disable=SC2086
    train_ablation "$earpoint" "$data" "out/ablations/recorded/$name" "$config" network.channels=16 \
      training.steps=400 training.validate_every=100 $settings
  done
}

# Recordings in the layout of Replay-NVAS: nine sessions of a minute in one flat, split by session, the clips that are
# cut from them, and the networks trained on these. Hours on two cores.
record_sessions() {
  local earpoint=$1 session name detector boxes methods=input,tf,dsp,gtf,vigas
  say "Recording simulated sessions into out/data/sessions, and their clips into out/data/recorded"
  "$earpoint" record simulate --scenarios 9 --minutes 1 --size 320x180 --samples 1 --seed 21 --out out/data/sessions
  for session in out/data/sessions/scenario-*/session.json; do
    "$earpoint" record prepare "$session" --out out/data/recorded
  done
  python3 experiments/measure/session_sync.py "$earpoint" "$speech_folder" out/data/sync \
    --sessions out/data/sessions/scenario-* >>out/bench/session_sync.jsonl
  : >out/bench/session_people.jsonl
  for detector in models/people.safetensors "$installed_detector"; do
    [ ! -f "$detector" ] || python3 experiments/measure/session_people.py "$earpoint" \
      out/data/sessions/scenario-000[78] --detector "$detector" >>out/bench/session_people.jsonl
  done
  train_recorded "$earpoint"
  methods+=,vam-recorded=out/runs/recorded/vam/best.safetensors
  for name in vigas-blind vigas; do
    methods+=,$name-recorded=out/ablations/recorded/$name/best.safetensors
  done
  for name in vigas gtf; do
    methods+=,$name-adapted=out/runs/recorded/$name-adapted/best.safetensors
  done
  methods+=,gtf-adapted=out/runs/recorded/gtf-adapted/best.safetensors:mean
  say "Methods side by side in recorded sessions: $methods"
  "$earpoint" evaluate --data out/data/recorded --layout replay --methods "$methods" --json \
    >out/bench/evaluate-recorded.json
  methods=input,gtf
  for name in adapted detected; do methods+=,gtf-$name=out/runs/recorded/gtf-$name/best.safetensors; done
  for boxes in detected true; do
    say "Networks that were trained with true and with detected boxes, told boxes: $boxes"
    "$earpoint" evaluate --data out/data/recorded --layout replay --boxes "$boxes" --methods "$methods" --json
  done >out/bench/boxes-recorded.jsonl
  say "Speech enhancement in recorded sessions"
  "$earpoint" evaluate --data out/data/recorded --layout replay --enhance --methods input,enhance \
    --runs out/enhance-recorded --json >out/bench/enhance-recorded.json
  say "Ablations in recorded sessions"
  "$earpoint" evaluate --data out/data/recorded --layout replay --ablations --runs out/ablations/recorded --json \
    >out/bench/ablations-recorded.json
}

# Ways to separate ambient sound: with the shipped networks, and with networks that were each trained on one way.
separate_ambient() {
  local earpoint=$1 data=out/data/novel kind
  say "Ways to separate ambient sound"
  python3 experiments/measure/ambient_separation.py "$earpoint" "$data" input,gtf,vigas --context 4 --limit 120 \
    >out/bench/separation-novel.md
  for kind in bandpass subtract mmse; do
    train_run "$earpoint" gtf "$data" "out/separation/$kind/gtf" network.init=models/gtf.safetensors \
      training.steps=300 training.learning_rate=0.0005 data.ambient_db=-40 "data.ambient=$kind"
    train_run "$earpoint" vigas-small "$data" "out/separation/$kind/vigas" network.init=models/vigas.safetensors \
      network.place_steps=0 training.steps=400 training.learning_rate=0.0003 training.warmup_steps=30 \
      training.validate_every=200 data.ambient_db=-40 "data.ambient=$kind"
  done
  say "The same with networks trained on each"
  python3 experiments/measure/ambient_separation.py "$earpoint" "$data" \
    "input,gtf=out/separation/{kind}/gtf/best.safetensors,vigas=out/separation/{kind}/vigas/best.safetensors" \
    --levels=-40 >out/bench/separation-trained.md
}

# Adds methods to a list, those whose weight files exist; all textures of gtf. Usage: with_methods LIST ROW=FILE...
with_methods() {
  local list=$1 method
  shift
  for method in "$@"; do
    [ -f "${method#*=}" ] || continue
    list+=,$method
    case $method in gtf*) list+=,$method:0.5,$method:mean ;; esac
  done
  echo "$list"
}

# The shipped networks, with all textures.
shipped_methods=vigas,gtf,gtf:0.5,gtf:mean

# What is compared in unseen homes: baselines that do not ship, the shipped networks, and these trained anew.
unseen_methods() {
  local runs=out/runs/novel methods
  methods=$(with_methods input,tf,dsp "vam=$runs/vam/best.safetensors" "vigas-blind=$runs/vigas-blind/best.safetensors")
  with_methods "$methods,$shipped_methods" "vigas-anew=$runs/vigas/best.safetensors" \
    "gtf-anew=$runs/gtf/best.safetensors"
}

# What is compared in one home: networks that have heard nothing else, shipped ones, and these trained on there.
one_home_methods() {
  local runs=out/runs/single short=out/ablations/single methods
  methods=$(with_methods input,tf,dsp "vam-one-home=$runs/vam/best.safetensors" \
    "vigas-blind-one-home=$short/vigas-blind/best.safetensors" "vigas-one-home=$short/vigas/best.safetensors")
  with_methods "$methods,$shipped_methods" "vigas-adapted=$runs/vigas-adapted/best.safetensors" \
    "gtf-adapted=$runs/gtf-adapted/best.safetensors"
}

# Methods side by side on the frozen test pairs, ablations and ambient sound, into out/bench. Usage: evaluate_methods
# EARPOINT DATA METHODS
evaluate_methods() {
  local earpoint=$1 data=$2 methods=$3
  say "Methods side by side in $data: $methods"
  "$earpoint" evaluate --data "out/data/$data" --methods "$methods" --oracles --json >"out/bench/evaluate-$data.json"
  if [ -d "out/ablations/$data" ]; then
    say "Ablations in $data"
    "$earpoint" evaluate --data "out/data/$data" --ablations --runs "out/ablations/$data" --json \
      >"out/bench/ablations-$data.json"
  fi
  if [ -d "out/ambient/$data" ]; then
    say "Ambient sound in $data"
    "$earpoint" evaluate --data "out/data/$data" --ambient -40 --methods input,dsp \
      --runs "out/ambient/$data" --json >"out/bench/ambient-$data.json"
  fi
}

# The methods of unseen homes with four seconds of sound before the second that is compared.
evaluate_context() {
  local earpoint=$1 methods
  methods=$(unseen_methods)
  say "Methods in unseen homes with preceding sound"
  "$earpoint" evaluate --data out/data/novel --methods "${methods/input,tf,/input,}" --context 4 --json \
    >out/bench/context-novel.json
}

# Farther away and in other rooms, with the people found in the picture as a user has it, with their true boxes, and
# with nothing told.
evaluate_places() {
  local earpoint=$1 boxes
  say "Methods farther away and in other rooms"
  for boxes in detected true none; do
    "$earpoint" evaluate --data out/data/places --boxes "$boxes" --methods "input,$shipped_methods" --json
  done >out/bench/places.jsonl
}

# The test splits with another head and another building: the same homes and conversations with the ears of
# KEMAR and of FABIAN (Debian's soundscaperenderer-common, unpacked and not installed), and a house that is
# read from a file.
simulate_generalisation() {
  local earpoint=$1 unpacked head
  local homes=(--scenes 12 --conversations 3 --split test --rays 1000 --seed 99)
  ensure_packages python3-netcdf4 python3-numpy
  mkdir -p out/data
  if [ ! -f out/data/fabian.sofa ]; then
    unpacked=$(mktemp -d)
    (cd "$unpacked" && apt-get download -qq -o APT::Sandbox::User=root soundscaperenderer-common) ||
      fail "could not fetch soundscaperenderer-common; try apt-get update"
    dpkg-deb -x "$unpacked"/soundscaperenderer-common_*.deb "$unpacked"
    head=$unpacked/usr/share/ssr/impulse_responses/hrirs/hrirs_fabian_min_phase_eq.wav
    python3 experiments/publish/fabian_sofa.py "$head" out/data/fabian.sofa
    rm -rf "$unpacked"
  fi
  python3 experiments/publish/make_house.py out/data/house.obj
  "$earpoint" simulate "${homes[@]}" --out out/data/kemar
  EARPOINT_HRTF=out/data/fabian.sofa "$earpoint" simulate "${homes[@]}" --out out/data/fabian
  "$earpoint" simulate --scene out/data/house.obj --up z --conversations 36 --split test \
    --rays 1000 --seed 99 --out out/data/imported
}

# Speech enhancement, and conditions for which gtf was not trained.
evaluate_beyond() {
  local earpoint=$1 methods shipped=models/enhance.safetensors
  say "Speech enhancement"
  methods=$(with_methods input vigas=out/enhance/vigas/best.safetensors "gtf=$shipped" \
    gtf-anew=out/enhance/gtf/best.safetensors)
  "$earpoint" evaluate --data out/data/novel --enhance --oracles --json --methods "$methods" \
    >out/bench/enhance-novel.json
  say "Generalisation of the shipped gtf"
  python3 experiments/measure/generalisation.py "$earpoint" out/data/novel models/gtf.safetensors \
    out/generalisation --every 2 >out/bench/generalisation.json
  simulate_generalisation "$earpoint"
  python3 experiments/measure/generalisation_heads.py "$earpoint" out/data/kemar out/data/fabian out/data/imported \
    models/gtf.safetensors out/generalisation >out/bench/generalisation_heads.json
}

# Physics and cost of the simulator.
measure_simulator() {
  local earpoint=$1
  say "Gates of the path tracer"
  build/release/experiments/measure/trace_gates >out/bench/trace_gates.md || failed_gates="the path tracer's"
  say "Speed of the path tracer"
  build/release/experiments/micro/trace_bench --plot docs/images/trace-cost.png >out/bench/trace_bench.json
  if python3 -c 'import pyroomacoustics' 2>/dev/null; then
    say "The path tracer beside pyroomacoustics"
    python3 experiments/peers/compare_tracers.py "$earpoint" >out/bench/compare_tracers.json
  else
    say "Not compared with pyroomacoustics, which this python3 does not have (pip install pyroomacoustics)"
  fi
  say "Pictures per second"
  build/release/experiments/micro/camera_bench >out/bench/camera_bench.jsonl
  say "Reverberation of 120 homes"
  build/release/experiments/measure/home_reverberation >out/bench/home_reverberation.jsonl
  say "Cost of simulated data"
  [ -f "$speech_folder/speech.csv" ] || gather_speech "$speech_folder"
  python3 experiments/measure/simulate_cost.py "$earpoint" "$speech_folder" >out/bench/simulate_cost.jsonl
  python3 experiments/measure/session_cost.py "$earpoint" "$speech_folder" >out/bench/session_cost.jsonl
  say "Clocks of simulated sessions"
  python3 experiments/measure/session_sync.py "$earpoint" "$speech_folder" out/data/sync >out/bench/session_sync.jsonl
}

# Whether killing a command loses anything or leaves anything behind.
measure_kills() {
  [ -f "$speech_folder/speech.csv" ] || gather_speech "$speech_folder"
  say "Killing commands at random moments"
  python3 experiments/stress/kill_anywhere.py "$1" "$speech_folder" examples/clip.mp4 out/kills >out/bench/kills.json
}

# Photographs of people and of things from Debian packages, which are unpacked and not installed, with the
# boxes of experiments/publish/photographs.json.
# Usage: gather_photographs FOLDER
gather_photographs() (
  local folder=$1/test/photographs unpacked package
  unpacked=$(mktemp -d)
  trap 'rm -rf "$unpacked"' EXIT
  mkdir -p "$folder"
  for package in python3-skimage opencv-doc; do
    (cd "$unpacked" && apt-get download -qq -o APT::Sandbox::User=root "$package") ||
      fail "could not fetch $package; try apt-get update"
    dpkg-deb -x "$unpacked/$package"_*.deb "$unpacked"
  done
  cp "$unpacked"/usr/lib/python3/dist-packages/skimage/data/{astronaut,camera,chelsea,coffee}.png \
    "$unpacked"/usr/lib/python3/dist-packages/skimage/data/rocket.jpg \
    "$unpacked"/usr/share/doc/opencv-doc/examples/data/{basketball1.png,basketball2.png,fruits.jpg,home.jpg,stuff.jpg} \
    "$folder"
  cp experiments/publish/photographs.json "$folder/people.json"
)

# People in pictures that our detector was not trained on, simulated and photographed: the shipped detector,
# and NanoDet if ./dev assets --people has installed it.
measure_detectors() {
  local detector data
  say "Finding people"
  build/release/apps/people_pictures/earpoint-people-pictures --seed 1 --train-homes 96 --val-homes 6 \
    --test-homes 12 --groups 6 --views 5 --split test --out out/data/people
  gather_photographs out/data/photographs
  : >out/bench/people_detection.jsonl
  for detector in models/people.safetensors "$installed_detector"; do
    [ -f "$detector" ] || continue
    for data in people novel photographs; do
      build/release/experiments/measure/people_detection "out/data/$data" test "$detector" | python3 -c \
        'import json, sys; print(json.dumps({"data": sys.argv[1], **json.load(sys.stdin)}))' "$data" \
        >>out/bench/people_detection.jsonl
    done
  done
}

# Everything that docs/results.md and the pages behind it show. The exactness table needs the reference outputs.
results() {
  bench
  local earpoint=build/release/apps/earpoint/earpoint data failed_gates=""
  if [ -n "${EARPOINT_ORACLE_DIR:-}" ]; then
    python3 experiments/measure/oracle_errors.py "$earpoint" "$EARPOINT_ORACLE_DIR" >out/bench/oracle_errors.md
  fi
  demo
  "$earpoint" evaluate --earpoints examples/earpoints.json --quiet --json >out/bench/demo.json
  cp out/demo/overview.jpg docs/images/demo.jpg
  measure_simulator "$earpoint"
  measure_kills "$earpoint"
  simulate_data "$earpoint"
  say "Training steps of gtf"
  python3 experiments/measure/gtf_training.py "$earpoint" configs/gtf.json out/data/novel out/bench
  train_methods "$earpoint"
  evaluate_methods "$earpoint" novel "$(unseen_methods)"
  evaluate_methods "$earpoint" single "$(one_home_methods)"
  evaluate_context "$earpoint"
  evaluate_places "$earpoint"
  separate_ambient "$earpoint"
  evaluate_beyond "$earpoint"
  record_sessions "$earpoint"
  for data in single novel; do
    python3 experiments/publish/learning_curves.py "out/runs/$data" "docs/images/learning-curves-$data.svg" \
      >"out/bench/learning_curves-$data.md"
  done
  if [ -f models/people.safetensors ]; then
    say "Who speaks"
    build/release/experiments/measure/active_speaker out/data/novel test shipped >out/bench/active_speaker.json
  fi
  build/release/experiments/measure/speaker_position out/data/novel test >out/bench/speaker_position.json
  build/release/experiments/measure/rt60_error out/data/novel test models/rt60.safetensors >out/bench/rt60_error.json
  measure_detectors
  python3 experiments/publish/write_results.py out/bench docs/results.md --readme README.md
  say "Wrote docs/results.md and docs/results/"
  [ -z "$failed_gates" ] || fail "$failed_gates gates do not hold: see docs/results/simulator.md"
}

# The whole process in miniature, from voices to tables, in minutes: six voices, twelve homes with stand-in
# furniture, networks that train for seconds. Compares every number with experiments/publish/quick_expected.json.
# EARPOINT_PRESET=dev takes the binary of the tests.
quick_results() {
  local preset=${EARPOINT_PRESET:-release} quick=$PWD/out/quick
  build "$preset" --target earpoint
  local earpoint=build/$preset/apps/earpoint/earpoint
  rm -rf "$quick"
  mkdir -p "$quick/bench"
  gather_speech "$quick/speech" \
    asterisk_en,tuxpaint_bg,asterisk_ru,tuxpaint_ru,asterisk_fr,asterisk_it
  say "Simulating twelve homes"
  EARPOINT_DATA_DIR=$quick/nothing "$earpoint" simulate --scenes 12 --conversations 2 --rays 300 \
    --seed 7 --speech "$quick/speech" --out "$quick/data"
  train_run "$earpoint" gtf "$quick/data" "$quick/runs/gtf-quick" data.validation_pairs=16 \
    training.steps=100 training.validate_every=50 training.warmup_steps=10
  train_run "$earpoint" vigas-small "$quick/data" "$quick/runs/vigas-quick" data.validation_pairs=16 \
    network.place_steps=20 training.steps=80 training.learning_rate=0.0001 training.validate_every=20 \
    training.warmup_steps=10 training.keep=last
  say "Methods side by side"
  "$earpoint" evaluate --data "$quick/data" --methods input,tf,dsp,gtf --runs "$quick/runs" --oracles \
    --json >"$quick/bench/evaluate-novel.json"
  python3 experiments/publish/write_results.py "$quick/bench" "$quick/results.md" --measured-only
  python3 experiments/publish/check_quick.py "$quick/bench/evaluate-novel.json" experiments/publish/quick_expected.json "$@"
  say "Wrote $quick/results.md"
}
