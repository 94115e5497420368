# Installs what was built, builds examples/library against it like an outside program, and runs it on the bundled clip's
# sound. Usage: cmake -DBINARY_DIR=... -DSOURCE_DIR=... -DCOMPILER=... -P TestInstalled.cmake
set(folder ${BINARY_DIR}/installed_test)
set(prefix ${folder}/prefix)
file(REMOVE_RECURSE ${folder})
file(MAKE_DIRECTORY ${folder})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(components renderer models)
file(GLOB lab ${BINARY_DIR}/libearpoint_lab.*)
if(lab)
  list(APPEND components lab)
endif()
foreach(component IN LISTS components)
  run(${CMAKE_COMMAND} --install ${BINARY_DIR} --prefix ${prefix} --component ${component})
endforeach()
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR}/examples/library -B ${folder}/build -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=-Werror)
run(${CMAKE_COMMAND} --build ${folder}/build)

find_program(FFMPEG ffmpeg REQUIRED)
run(${FFMPEG} -v error -i ${SOURCE_DIR}/examples/clip.mp4 -vn -c:a pcm_f32le ${folder}/clip.wav)
set(ENV{EARPOINT_MODELS_DIR} ${prefix}/share/earpoint/models)
run(${folder}/build/listen ${folder}/clip.wav ${folder}/whole.wav ${folder}/live.wav)
if(lab)
  run(${folder}/build/room)
endif()
