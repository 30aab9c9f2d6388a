# SPDX-License-Identifier: Apache-2.0
# zt_warnings: what every target of this project compiles with; link it PRIVATE.
# Contraction is off because the specification fixes the order of floating-point operations, and excess precision because
# it fixes their width (s390x computes floats as doubles where C11 lets it).

add_library(zt_warnings INTERFACE)
target_compile_options(zt_warnings INTERFACE
  -ffp-contract=off
  -fno-fast-math
  $<$<C_COMPILER_ID:GNU>:-fexcess-precision=fast>)
if(PROJECT_IS_TOP_LEVEL)
  target_compile_options(zt_warnings INTERFACE
    -Wall -Wextra -Wconversion -Wshadow -Wvla -Wundef -Wformat=2 -Wpointer-arith -Wcast-qual
    -Wwrite-strings
    $<IF:$<C_COMPILER_ID:GNU>,-Wcast-align=strict,-Wcast-align>
    $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes>
    $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes>
    $<$<COMPILE_LANGUAGE:C>:-Wold-style-definition>
    $<$<BOOL:${ZT_WERROR}>:-Werror>)
endif()
