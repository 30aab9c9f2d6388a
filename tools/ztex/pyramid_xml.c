/* SPDX-License-Identifier: Apache-2.0 */
/* Descriptors in XML: elements with attributes, and nothing else. */
#include "pyramid.h"

#include <expat.h>
#include <stdio.h>
#include <string.h>

typedef struct walk {
    XML_Parser parser;
    pyramid_visit *visit;
    void *user;
    unsigned depth;
    const char *wrong;
} walk;

/* The name without the prefix of its namespace. */
static const char *plain(const char *name) {
    const char *colon = strrchr(name, ':');
    return colon ? colon + 1 : name;
}

static void stop(walk *w, const char *wrong) {
    w->wrong = wrong;
    XML_StopParser(w->parser, XML_FALSE);
}

static void XMLCALL begin_element(void *user, const char *name, const char **pairs) {
    walk *w = user;
    const char *wrong = w->visit(w->user, w->depth++, plain(name), pairs);
    if (wrong)
        stop(w, wrong);
}

static void XMLCALL end_element(void *user, const char *name) {
    (void)name;
    ((walk *)user)->depth--;
}

/* Entities could blow it up. */
static void XMLCALL begin_doctype(void *user, const char *name, const char *system, const char *public, int inside) {
    (void)name, (void)system, (void)public, (void)inside;
    stop(user, "a document type has no place in a descriptor");
}

int pyramid_parse_xml(const char *text, size_t size, pyramid_visit *visit, void *user, char *error) {
    walk w = {.parser = XML_ParserCreate(NULL), .visit = visit, .user = user};
    if (!w.parser) {
        snprintf(error, IMG_ERROR, "out of memory");
        return -1;
    }
    XML_SetUserData(w.parser, &w);
    XML_SetElementHandler(w.parser, begin_element, end_element);
    XML_SetStartDoctypeDeclHandler(w.parser, begin_doctype);
    int good = XML_Parse(w.parser, text, (int)size, 1) == XML_STATUS_OK;
    if (!good && w.wrong)
        snprintf(error, IMG_ERROR, "%s", w.wrong);
    else if (!good)
        snprintf(error, IMG_ERROR, "line %lu: %s", (unsigned long)XML_GetCurrentLineNumber(w.parser),
                 XML_ErrorString(XML_GetErrorCode(w.parser)));
    XML_ParserFree(w.parser);
    return good ? 0 : -1;
}

uint32_t pyramid_whole(const char *text) {
    uint64_t value = 0;
    if (!*text)
        return UINT32_MAX;
    for (; *text; text++) {
        if (*text < '0' || *text > '9' || value > UINT32_MAX / 10 - 1)
            return UINT32_MAX;
        value = 10 * value + (uint64_t)(*text - '0');
    }
    return (uint32_t)value;
}
