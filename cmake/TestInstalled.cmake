# Installs what was built, builds examples/library and examples/c against it like outside programs, and runs them on the
# bundled clip's sound: both must give the same samples.
# Usage: cmake -DBINARY_DIR=... -DSOURCE_DIR=... -DCOMPILER=... -P TestInstalled.cmake
set(folder ${BINARY_DIR}/installed_test)
set(prefix ${folder}/prefix)
file(REMOVE_RECURSE ${folder})
file(MAKE_DIRECTORY ${folder})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(components renderer renderer_library models)
file(GLOB lab ${BINARY_DIR}/libearpoint_lab.*)
if(lab)
  list(APPEND components lab lab_library)
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

# The C example: by CMake without C++, and by what pkg-config says.
set(warnings -Wall -Wextra -pedantic -Werror)
list(JOIN warnings " " c_flags)
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR}/examples/c -B ${folder}/build_c -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${prefix} "-DCMAKE_C_FLAGS=${c_flags}")
run(${CMAKE_COMMAND} --build ${folder}/build_c)
file(GLOB_RECURSE pc_file ${prefix}/earpoint.pc)
cmake_path(GET pc_file PARENT_PATH libraries)
cmake_path(GET libraries PARENT_PATH libraries)
set(ENV{PKG_CONFIG_PATH} ${libraries}/pkgconfig)
execute_process(COMMAND pkg-config --cflags --libs earpoint sndfile OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(cc -std=c99 ${warnings} ${SOURCE_DIR}/examples/c/listen.c -o ${folder}/listen_c ${flags})
set(ENV{LD_LIBRARY_PATH} ${libraries})
foreach(program IN ITEMS build_c/listen listen_c)
  run(${folder}/${program} ${folder}/clip.wav ${folder}/whole_c.wav ${folder}/live_c.wav)
  foreach(what IN ITEMS whole live)
    # Samples alone: the header of a WAV file has a time.
    foreach(language IN ITEMS "" _c)
      run(${FFMPEG} -v error -y -i ${folder}/${what}${language}.wav -f f32le ${folder}/${what}${language}.raw)
    endforeach()
    run(${CMAKE_COMMAND} -E compare_files ${folder}/${what}.raw ${folder}/${what}_c.raw)
  endforeach()
endforeach()
