# Writes the Turtle files of the LV2 bundle: asks the plugin by lv2_generator.cpp, and calls optional what lv2_entry.cpp
# does without. Usage: cmake -DGENERATOR=... -DPLUGIN=... -DBUNDLE=... -P describe_lv2.cmake
execute_process(COMMAND ${GENERATOR} ${PLUGIN} WORKING_DIRECTORY ${BUNDLE} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
set(file ${BUNDLE}/earpoint.ttl)
file(READ ${file} text)
string(FIND "${text}" "lv2:requiredFeature opts:options" place)
if(place EQUAL -1)
  message(FATAL_ERROR "${file} does not require options; this DPF writes other files than version 1.6")
endif()
string(REPLACE "lv2:requiredFeature" "lv2:optionalFeature" text "${text}")
# Names for one maker's devices, in a vocabulary that LV2 does not have.
string(REGEX REPLACE "[ \t]*mod:[a-z]+ \"[^\"]*\" ;\n" "" text "${text}")
string(REGEX REPLACE "@prefix mod:[^\n]*\n" "" text "${text}")
file(WRITE ${file} "${text}")
