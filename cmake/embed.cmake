# SPDX-License-Identifier: Apache-2.0
# tallow_embed_text(TARGET FILE SYMBOL): compiles a text file into a library as a string, so that
# programs need no data folder. embed_text.cmake writes the source.
function(tallow_embed_text target file symbol)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${symbol}.cpp)
  set(script ${PROJECT_SOURCE_DIR}/cmake/embed_text.cmake)
  add_custom_command(
    OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} -DINPUT=${PROJECT_SOURCE_DIR}/${file} -DOUTPUT=${source}
            -DSYMBOL=${symbol} -P ${script}
    DEPENDS ${PROJECT_SOURCE_DIR}/${file} ${script}
    VERBATIM)
  target_sources(${target} PRIVATE ${source})
endfunction()
