# SPDX-License-Identifier: Apache-2.0
# Presets other than debug compile the sources of a target together, eight at a time
# (CMAKE_UNITY_BUILD): most of the time of a source goes into headers and templates that its
# neighbours need as well.

# tallow_compile_alone(SOURCE...): these are compiled one by one all the same, because they give a
# meaning of their own to a local name that a neighbour uses too, or because Highway includes them
# again for each instruction set.
function(tallow_compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
