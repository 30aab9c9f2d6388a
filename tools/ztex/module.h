/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Modules of the command: shared libraries of its own that are loaded when they are first needed, because what they
 * link takes longer to load than most verbs take to run.
 */
#ifndef ZTEX_MODULE_H
#define ZTEX_MODULE_H

#define MODULE_ERROR 256

/* The table of functions that `file` exports as `symbol`; it stays loaded. NULL with one line in error (MODULE_ERROR
 * bytes) that begins with the file's name. Any thread may call it; callers keep the result. */
const void *module_load(const char *file, const char *symbol, char *error);

#endif
