# SPDX-License-Identifier: Apache-2.0
# Sanitizers and coverage change code generation everywhere, so they are not per target.

if(ZT_SANITIZE)
  add_compile_options(-fsanitize=${ZT_SANITIZE} -fno-omit-frame-pointer)
  # libFuzzer's own flag belongs to the targets that have an entry point for it.
  string(REGEX REPLACE "fuzzer-no-link,?" "" zt_link_sanitize "${ZT_SANITIZE}")
  add_link_options(-fsanitize=${zt_link_sanitize})
  if(ZT_SANITIZE MATCHES "address|undefined|memory")
    add_compile_options(-fno-sanitize-recover=all)
    add_link_options(-fno-sanitize-recover=all)
  endif()
endif()

if(ZT_COVERAGE)
  add_compile_options(-fprofile-instr-generate -fcoverage-mapping)
  add_link_options(-fprofile-instr-generate)
endif()
