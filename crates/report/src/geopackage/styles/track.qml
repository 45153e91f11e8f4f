<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.22" styleCategories="Symbology|Labeling" labelsEnabled="1">
  <renderer-v2 type="categorizedSymbol" attr="if(&quot;informative&quot;, 1, 0)">
    <categories>
      <category value="1" symbol="0" label="maneuver" render="true"/>
      <category value="0" symbol="1" label="way between maneuvers" render="true"/>
    </categories>
    <symbols>
      <symbol type="line" name="0">
        <layer class="SimpleLine">
          <prop k="line_color" v="0,114,178,255"/>
          <prop k="line_width" v="0.8"/>
        </layer>
      </symbol>
      <symbol type="line" name="1">
        <layer class="SimpleLine">
          <prop k="line_color" v="98,102,106,255"/>
          <prop k="line_width" v="0.5"/>
        </layer>
      </symbol>
    </symbols>
  </renderer-v2>
  <labeling type="simple">
    <settings>
      <text-style isExpression="1" fieldName="if(&quot;informative&quot;, &quot;name&quot;, NULL)" fontSize="8" fontSizeUnit="Point" textColor="0,114,178,255">
        <text-buffer bufferDraw="1" bufferSize="0.8" bufferColor="255,255,255,220"/>
      </text-style>
      <placement placement="2" placementFlags="2" dist="0.6"/>
    </settings>
  </labeling>
  <layerGeometryType>1</layerGeometryType>
</qgis>
